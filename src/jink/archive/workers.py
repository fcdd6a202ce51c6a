"""Who does the work: this process, processes of this machine, or a cluster of dask. All run the same functions."""

from __future__ import annotations

import gc
import multiprocessing
import os
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import Any, Protocol

from .errors import Stopped

Task = tuple[Callable[..., Any], tuple[Any, ...]]
LOSSES = 3  # times that a process may die before the run ends


class Workers(Protocol):
    """Runs tasks and gives what they return, in the order in which they are done, until it is closed. Errors: those of
    the tasks.
    """

    def run(self, tasks: Iterable[Task]) -> Iterator[Any]: ...
    def close(self) -> None: ...


class Here:
    """This process."""

    def run(self, tasks: Iterable[Task]) -> Iterator[Any]:
        """One after the other."""
        for function, arguments in tasks:
            yield function(*arguments)

    def close(self) -> None:
        """Nothing is to be done."""


class Processes:
    """Processes of this machine, the same for all tasks; they end when this one does, however it ends."""

    def __init__(self, count: int):
        self.count = count
        self._pool: ProcessPoolExecutor | None = None

    def run(self, tasks: Iterable[Task]) -> Iterator[Any]:
        """A few tasks more than processes are under way. Errors: Stopped where processes die again and again."""
        waiting, losses = iter(tasks), 0
        under_way: dict[Future[Any], Task] = {}
        again: list[Task] = []
        with _one_thread_each():
            self._pool = self._pool or self._executor()
            while True:
                while len(under_way) < 2 * self.count and (task := again.pop() if again else next(waiting, None)):
                    under_way[_submitted(self._pool, task)] = task
                if not under_way:
                    return
                done, _ = wait(under_way, return_when=FIRST_COMPLETED)
                for future in done:
                    task = under_way.pop(future)
                    try:
                        result = future.result()
                    except BrokenProcessPool:
                        again.append(task)
                        continue
                    yield result
                if again:
                    losses += 1
                    if losses > LOSSES:
                        raise Stopped("processes end again and again; give a smaller --memory or fewer --threads")
                    again += under_way.values()
                    under_way.clear()
                    self._pool.shutdown(wait=False, cancel_futures=True)
                    self._pool = self._executor()

    def close(self) -> None:
        """End the processes, once their tasks are done."""
        if self._pool is not None:
            self._pool.shutdown(wait=True, cancel_futures=True)
            self._pool = None

    def _executor(self) -> ProcessPoolExecutor:
        context = multiprocessing.get_context("spawn")
        return ProcessPoolExecutor(self.count, context, initializer=_begin, initargs=(os.getpid(), gc.get_threshold()))


def _submitted(pool: ProcessPoolExecutor, task: Task) -> Future[Any]:
    """What will hold the result. It failed already where a process ended while there was nothing to do."""
    try:
        return pool.submit(task[0], *task[1])
    except BrokenProcessPool as error:
        failed: Future[Any] = Future()
        failed.set_exception(error)
        return failed


@contextmanager
def _one_thread_each() -> Iterator[None]:
    """Processes that begin within it, as many as the cores, have one thread of polars."""
    before = os.environ.get("POLARS_MAX_THREADS")
    os.environ["POLARS_MAX_THREADS"] = "1"
    try:
        yield
    finally:
        if before is None:
            del os.environ["POLARS_MAX_THREADS"]
        else:
            os.environ["POLARS_MAX_THREADS"] = before


def _begin(parent: int, garbage: tuple[int, ...]) -> None:
    """What a process does first."""
    # garbage is looked for as often as in the parent
    gc.set_threshold(*garbage)
    from .._engine import native

    # one bucket's memory is the next one's, so that no array costs new pages
    native.keep_freed_memory()
    _end_with(parent)


def _end_with(parent: int) -> None:
    """End this process soon after its parent, which may be killed without a word."""

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(0.2)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


class Cluster:
    """Workers of dask; one that dies is replaced by another, and its task is done again."""

    def __init__(self, client: Any):
        self.client = client

    @classmethod
    def at(cls, address: str) -> Cluster:
        """Those of a scheduler, such as `tcp://host:8786`. Errors: Stopped."""
        try:
            from distributed import Client
        except ImportError:
            raise Stopped('distributed is missing; pip install "jink[cluster]" brings it') from None
        try:
            return cls(Client(address, timeout=20))
        except (OSError, ValueError) as error:
            raise Stopped(f"--cluster {address}: no scheduler answers: {error}") from None

    def run(self, tasks: Iterable[Task]) -> Iterator[Any]:
        """A few tasks more than workers are under way."""
        from distributed import as_completed

        waiting = iter(tasks)
        some = [self._submit(task) for _, task in zip(range(self._most()), waiting, strict=False)]
        under_way = as_completed(some)
        try:
            for future in under_way:
                result = future.result()
                future.release()
                if (task := next(waiting, None)) is not None:
                    under_way.add(self._submit(task))
                yield result
        finally:
            self.client.cancel(list(under_way.futures))

    def close(self) -> None:
        """The cluster goes on."""

    def _submit(self, task: Task) -> Any:
        return self.client.submit(task[0], *task[1], pure=False, retries=0)

    def _most(self) -> int:
        return max(4, 3 * len(self.client.scheduler_info(n_workers=-1)["workers"]))
