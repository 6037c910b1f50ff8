"""Executors: where work is done side by side, in processes of this machine or by the workers of a Ray cluster.

Who has work calls `each_done`, and says how many may do it; where it is done is said once, around it all, as by
`with on_ray(): ...`. No result depends on it.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any

from joblib import Parallel, parallel_config, register_parallel_backend

Work = tuple[Callable[..., Any], Any, Any]  # what joblib's `delayed` makes of a call

_ON_RAY = "blockstab_on_ray"


def each_done(work: Iterable[Work], jobs: int, in_order: bool = True) -> Iterator[Any]:
    """Results of calls that are made side by side, each as soon as it is there.

    Args:
        jobs: calls made at one time; -1: as many as there are processors.
        in_order: give them in the order of the calls; else as they come.
    """
    return_as = "generator" if in_order else "generator_unordered"
    results: Iterator[Any] = Parallel(n_jobs=jobs, return_as=return_as)(work)
    return results


@contextmanager
def local() -> Iterator[None]:
    """Processes of this machine."""
    yield


@contextmanager
def on_ray(address: str | None = None, cpus: int | None = None) -> Iterator[None]:
    """Workers of a Ray cluster, which must see the same files under the same paths.

    Args:
        address: of a cluster that is there, such as `ray://head:10001`; None: a cluster of this machine alone is
            started, and stopped in the end.
        cpus: of a cluster that is started; None: all.

    Raises:
        ValueError: Ray is not installed, or there is no such cluster.
    """
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    try:
        import ray
        from ray.util.joblib.ray_backend import RayBackend
    except ModuleNotFoundError:
        raise ValueError(
            "executor=ray needs Ray, which is not installed; run: pip install 'blockstab[ray]'"
        ) from None

    class Backend(RayBackend):
        # Ray says nothing of generators, which came to joblib later; it calls back for every result, as they need.
        supports_return_generator = True

    register_parallel_backend(_ON_RAY, Backend)
    quiet: dict[str, Any] = {"log_to_driver": False, "logging_level": "ERROR", "include_dashboard": False}
    try:
        ray.init(address, **quiet) if address else ray.init(num_cpus=cpus, **quiet)
    except (ConnectionError, RuntimeError) as error:
        raise ValueError(
            f"There is no Ray cluster at {address}: {error}; start one, or leave it out."
        ) from None
    try:
        with parallel_config(_ON_RAY):
            yield
    finally:
        ray.shutdown()
