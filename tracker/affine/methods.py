"""The filters of [IGPF2021] by name: what PF, GPF and IGPF differ in, whatever they follow."""

from dataclasses import dataclass, replace
from typing import Literal

from tracker.affine.filter import FilterConfig


@dataclass(frozen=True)
class FilterMethod:
    """The exchangeable parts of one particle filter; each is a field of `FilterConfig`."""

    description: str
    """One line for listings."""
    state_space: Literal["group", "vector"]
    proposal: Literal["gaussian", "prior"]
    resampling: str

    def applied_to(self, config: FilterConfig) -> FilterConfig:
        """Returns `config` with the parts of this method; all other settings stay."""
        return replace(
            config,
            state_space=self.state_space,
            proposal=self.proposal,
            resampling=self.resampling,
        )


METHODS: dict[str, FilterMethod] = {
    "igpf": FilterMethod(
        "particles on Aff(2), Gaussian proposal, improved Gaussian resampling",
        state_space="group",
        proposal="gaussian",
        resampling="improved-gaussian",
    ),
    "gpf": FilterMethod(
        "particles on Aff(2), Gaussian proposal, residual resampling",
        state_space="group",
        proposal="gaussian",
        resampling="residual",
    ),
    "pf": FilterMethod(
        "vector of affine parameters, transition prior, systematic resampling",
        state_space="vector",
        proposal="prior",
        resampling="systematic",
    ),
}
