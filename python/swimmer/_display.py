"""Results as text for terminals and as tables for notebooks."""

from __future__ import annotations

import html
import math
from collections.abc import Iterable

import numpy as np

Row = tuple[str, str]


def with_error(value: float, error: float | None) -> str:
    """A number with its error bar of two digits, and the same in percent.

    >>> with_error(0.160418016, 0.000012)
    '0.160418 +- 0.000012 (0.0075 %)'
    >>> with_error(2.0, None)
    '2 (error not estimated)'
    >>> with_error(6.28318530718, 0.0)
    '6.28318530718'
    """
    if error is None or math.isnan(error):
        return f"{value:.6g} (error not estimated)"
    if error == 0.0 or not math.isfinite(error):
        return f"{value:.12g}" if error == 0.0 else f"{value:.6g} +- {error}"
    last = 1 - math.floor(math.log10(error))
    if last > 15 or last < -6 or abs(value) >= 1e15:
        text = f"{value:.15g} +- {error:.1e}"
    else:
        digits = max(last, 0)
        text = f"{value:.{digits}f} +- {error:.{digits}f}"
    return f"{text} ({100 * error / abs(value):.2g} %)" if value != 0.0 else text


def vector(values: Iterable[float]) -> str:
    """A vector with eight digits."""
    return "(" + ", ".join(f"{value + 0.0:.8g}" for value in values) + ")"


def largest(vectors: np.ndarray) -> float:
    """The largest length of the rows of an array; zero without rows."""
    return float(np.linalg.norm(vectors, axis=-1).max(initial=0.0))


class Result:
    """Base of all results: `repr` is a list of label and value, `_repr_html_` a table."""

    __slots__ = ()

    def _rows(self) -> list[Row]:
        raise NotImplementedError

    def __repr__(self) -> str:
        rows = self._rows()
        width = max(len(label) for label, _ in rows)
        lines = [f"{label:<{width}}  {value}".rstrip() for label, value in rows]
        return "\n".join([type(self).__name__, *(f"  {line}" for line in lines)])

    def _repr_html_(self) -> str:
        cells = "".join(
            f'<tr><th scope="row" style="text-align:left">{html.escape(label)}</th>'
            f'<td style="text-align:left">{html.escape(value)}</td></tr>'
            for label, value in self._rows()
        )
        name = html.escape(type(self).__name__)
        return f"<table><caption>{name}</caption><tbody>{cells}</tbody></table>"
