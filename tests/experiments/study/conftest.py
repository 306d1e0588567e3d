"""A cluster of two Dask workers for all tests of a process."""

import pytest
import toy_cluster


@pytest.fixture(scope="session")
def cluster(tmp_path_factory):
    """See `toy_cluster.cluster`."""
    with toy_cluster.cluster(tmp_path_factory.mktemp("dask")) as found:
        yield found
