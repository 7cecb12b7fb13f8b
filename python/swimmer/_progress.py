"""Progress of long calls: a bar of tqdm, if it is installed."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import contextmanager
from typing import Any, Iterator

Report = Callable[[int, int, str], None]


@contextmanager
def reporter(progress: bool | Report, what: str) -> Iterator[Report | None]:
    """The function to report progress to.

    `progress` is a function of the numbers of completed and of all parts and a text, or whether to
    show a bar. The bar appears with the first report, after a twentieth of a second.
    """
    if callable(progress):
        yield progress
        return
    tqdm = _tqdm() if progress else None
    if tqdm is None:
        yield None
        return
    bar = None

    def report(done: int, total: int, text: str) -> None:
        nonlocal bar
        if bar is None:
            bar = tqdm(desc=what, unit="part", leave=False)
        bar.total = total or None
        bar.n = done
        bar.set_postfix_str(text)

    try:
        yield report
    finally:
        if bar is not None:
            bar.close()


def _tqdm() -> Any:
    try:
        from tqdm.auto import tqdm  # type: ignore[import-untyped, unused-ignore]
    except ImportError:
        return None
    return tqdm
