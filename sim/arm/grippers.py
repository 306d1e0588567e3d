"""The grippers: what a command may ask of them; their bodies, forces and springs are models."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Gripper:
    """A gripper of two fingers that one drive moves alike."""

    xml: str
    """Path of the MJCF file inside the assets folder."""
    stroke_m: float
    """Largest opening, as the drive has it: between the pads of straight fingers."""
    speed_mps: float
    """Rate at which the opening changes, both fingers together."""
    force_n: float
    """Largest closing force of each finger."""


RG2 = Gripper(xml="grippers/rg2.xml", stroke_m=0.110, speed_mps=0.127, force_n=40.0)

SOFT = Gripper(xml="grippers/soft.xml", stroke_m=0.150, speed_mps=0.200, force_n=15.0)
"""Leaning inwards while nothing is held, its pads leave 0.12 m of the stroke; assets/PROVENANCE.md
says where the numbers come from."""
