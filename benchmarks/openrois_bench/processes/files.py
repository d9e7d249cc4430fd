"""Open files of the process of a bench: each connection takes one."""

import resource

from openrois_bench.errors import BenchFailed

__all__ = ["allow_files"]


def allow_files(wanted: int) -> None:
    """Take as many open files as are needed; processes that are started from then on may have as many.

    Raises:
        BenchFailed: the system allows fewer.
    """
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if hard != resource.RLIM_INFINITY and hard < wanted:
        raise BenchFailed(f"the system allows {hard} open files, and {wanted} are needed: raise ulimit -n")
    if soft != resource.RLIM_INFINITY and soft < wanted:
        resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))
