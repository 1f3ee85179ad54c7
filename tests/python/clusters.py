"""Clusters of Dask for tests, which may run beside each other."""

from dask.distributed import LocalCluster


def cluster(workers: int) -> LocalCluster:
    """Workers of one thread each, on this machine, whose scheduler takes any free port for its pages."""
    return LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=":0")
