"""What the functions return: records with attributes, and tables with a NumPy array for each column."""

from __future__ import annotations

import base64
import html
import struct
import zlib
from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ._native import __version__

if TYPE_CHECKING:
    import pandas
    import xarray

# What a name ends in, longest first, and the unit that it stands for.
_UNITS = {
    "_m_per_s2": "m/s2", "_m_per_s": "m/s", "_n_s": "N s", "_per_s": "1/s", "_hz": "Hz", "_mm": "mm", "_um": "um", "_ms": "ms", "_kg": "kg",
    "_percent": "%", "_turns": "turn", "_ratio": "1", "_n": "N", "_s": "s", "_j": "J", "_w": "W",
}


# What made a data set.
_SOURCE = {"source": f"vibroimpact {__version__}"}
# The colours of the command line's pictures, and that of every other p/n.
_COLOURS = {
    "1/1": "0072b2", "2/2": "009e73", "4/4": "9ae0c4", "1/2": "e69f00", "2/4": "fbe0a0", "1/3": "f0e442", "1/4": "a8a21e",
    "2/1": "882255", "3/1": "b85cc0", "3/2": "332288", "aperiodic": "383838", "unsettled": "905010", "chatter": "cc79a7",
    "none": "e8e8e8", "no impact": "e8e8e8", "failed": "ffffff",
}
_OTHER = "c9b8f0"


class Record(Mapping[str, Any]):
    """An answer. Its fields are attributes, and items as in a mapping; their units are in their names.

    ``record.force_ratio`` and ``record["force_ratio"]`` are the same. ``dict(record)`` gives the fields, and
    :meth:`to_dict` gives them with everything below as plain Python values.
    """

    def __init__(self, fields: Mapping[str, Any]) -> None:
        self._fields = {key: _wrapped(value) for key, value in fields.items()}

    def __getitem__(self, key: str) -> Any:
        return self._fields[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._fields)

    def __len__(self) -> int:
        return len(self._fields)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        try:
            return self._fields[name]
        except KeyError:
            fields = ", ".join(self._fields)
            raise AttributeError(f"there is no field {name}; there are {fields}") from None

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._fields]

    def __eq__(self, other: object) -> bool:
        """Whether all fields are the same; a NaN equals a NaN in the same place."""
        return isinstance(other, Record) and self._fields.keys() == other._fields.keys() and all(
            _same(value, other._fields[key]) for key, value in self._fields.items())

    def __getstate__(self) -> dict[str, Any]:
        return self._fields

    def __setstate__(self, state: dict[str, Any]) -> None:
        self._fields = state

    def __repr__(self) -> str:
        lines = (f"  {key}={_short(value)}" for key, value in self._fields.items())
        return f"{type(self).__name__}(\n" + ",\n".join(lines) + "\n)"

    def _repr_html_(self) -> str:
        return _curve(self._fields) + _html((), self._fields.items())

    def to_dict(self) -> dict[str, Any]:
        """The fields as plain Python values: dictionaries, lists, numbers and strings."""
        return {key: _plain(value) for key, value in self._fields.items()}


class Table(Record):
    """Rows as columns: each field is an array with one value for each row.

    Numbers that a row does not have are NaN; words that it does not have are ``None``.
    """

    if TYPE_CHECKING:
        def __getattr__(self, name: str) -> np.ndarray: ...
        def __getitem__(self, key: str) -> np.ndarray: ...

    def __init__(self, columns: Mapping[str, Any]) -> None:
        self._fields = {key: _column(values) for key, values in columns.items()}

    @property
    def rows(self) -> int:
        """How many rows there are."""
        return len(next(iter(self._fields.values()))) if self._fields else 0

    def row(self, index: int) -> Record:
        """One row."""
        return Record({key: values[index] for key, values in self._fields.items()})

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.rows} rows: {', '.join(self._fields)})"

    def _repr_html_(self) -> str:
        first = zip(*(values[:10] for values in self._fields.values()))
        return _curve(self._fields) + _html(self._fields, first) + f"<p>{self.rows} rows</p>"

    def to_pandas(self) -> pandas.DataFrame:
        """The table as a ``pandas.DataFrame`` (needs pandas)."""
        import pandas

        return pandas.DataFrame(dict(self._fields))

    def to_xarray(self) -> xarray.Dataset:
        """The table as an ``xarray.Dataset`` over the dimension ``row`` (needs xarray)."""
        import xarray

        return xarray.Dataset({key: ("row", values, _unit(key)) for key, values in self._fields.items()}, attrs=_SOURCE)


class Grid(Record):
    """Values over two axes. :attr:`axes` names them; each layer has the shape of the axes."""

    def __init__(self, fields: Mapping[str, Any], axes: tuple[str, str], layers: tuple[str, ...]) -> None:
        super().__init__(fields)
        self._axes, self._layers = axes, layers

    def __getstate__(self) -> dict[str, Any]:
        return {"fields": self._fields, "axes": self._axes, "layers": self._layers}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self._fields, self._axes, self._layers = state["fields"], state["axes"], state["layers"]

    @property
    def axes(self) -> tuple[str, str]:
        """Names of the rows' and the columns' coordinate."""
        return self._axes

    @property
    def layers(self) -> tuple[str, ...]:
        """Names of what is known of each cell."""
        return self._layers

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        rows, columns = self._axes
        return len(self._fields[rows]), len(self._fields[columns])

    def __repr__(self) -> str:
        rows, columns = self._axes
        at = f"{self.shape[0]} x {self.shape[1]} cells over {rows} and {columns}"
        return f"{type(self).__name__}({at}: {', '.join(self._layers)})"

    def _repr_html_(self) -> str:
        """The first layer of names as a picture, with the share of each name."""
        named = next(name for name in self._layers if self._fields[name].dtype.kind == "U")
        names, index, cells = np.unique(self._fields[named], return_inverse=True, return_counts=True)
        colours = [_COLOURS.get(name, _OTHER) for name in names]
        png = base64.b64encode(_png(index.reshape(self.shape)[::-1], [bytes.fromhex(one) for one in colours])).decode()
        shares = sorted(zip(cells / index.size, names, colours), reverse=True)[:8]
        legend = (f'<span style="color:#{colour}">&#9632;</span> {html.escape(name)} {share:.1%}' for share, name, colour in shares)
        rows, columns = ("{0} {1[0]:.4g} to {1[1]:.4g}".format(axis, self._fields[axis][[0, -1]]) for axis in self._axes)
        return (
            f"<p>{named}: {' '.join(legend)}</p>"
            f'<img src="data:image/png;base64,{png}" alt="{named}" style="width:480px;height:320px;image-rendering:pixelated">'
            f"<p>{columns}; upwards {rows}</p>" + _html((), self._fields.items())
        )

    def to_pandas(self) -> pandas.DataFrame:
        """A ``pandas.DataFrame`` with a row for each cell (needs pandas)."""
        import pandas

        rows, columns = (self._fields[axis] for axis in self._axes)
        there = {self._axes[0]: np.repeat(rows, len(columns)), self._axes[1]: np.tile(columns, len(rows))}
        return pandas.DataFrame(there | {name: self._fields[name].ravel() for name in self._layers})

    def to_xarray(self) -> xarray.Dataset:
        """An ``xarray.Dataset`` over the two axes, with units, and with rig and options as attributes (needs xarray)."""
        import xarray

        layers = {name: (self._axes, self._fields[name], _unit(name)) for name in self._layers}
        axes = {axis: (axis, self._fields[axis], _unit(axis)) for axis in self._axes}
        said = {key: value for key, value in self._fields.items() if isinstance(value, (str, int, float))}
        return xarray.Dataset(layers, axes, said | _SOURCE)


def _unit(name: str) -> dict[str, str]:
    """The attribute ``units`` of a variable of this name, if it has one."""
    return next(({"units": unit} for end, unit in _UNITS.items() if name.endswith(end)), {})


def _png(index: np.ndarray, colours: list[bytes]) -> bytes:
    """A picture with a palette: a colour's place for each cell, the first row on top."""
    def part(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    height, width = index.shape
    lines = np.pad(index.astype(np.uint8), ((0, 0), (1, 0))).tobytes()
    head = part(b"IHDR", struct.pack(">2I5B", width, height, 8, 3, 0, 0, 0)) + part(b"PLTE", b"".join(colours))
    return b"\x89PNG\r\n\x1a\n" + head + part(b"IDAT", zlib.compress(lines)) + part(b"IEND", b"")


def _curve(fields: Mapping[str, Any]) -> str:
    """Force over frequency, where the fields have both, as a picture."""
    for x, y in [("curve_frequency_hz", "curve_force_ratio"), ("frequency_hz", "force_ratio")]:
        over, force = fields.get(x), fields.get(y)
        if isinstance(over, np.ndarray) and isinstance(force, np.ndarray) and len(over) > 1 and np.ptp(over) > 0 and np.nanmax(force) > 0:
            at = zip(580 * (over - over.min()) / np.ptp(over) + 10, 190 - 170 * force / np.nanmax(force))
            points = "".join(f'<circle cx="{a:.1f}" cy="{b:.1f}" r="2"/>' for a, b in at if b == b)
            said = f"{y}, 0 to {np.nanmax(force):.4g}, over {x}, {over.min():.4g} to {over.max():.4g}"
            frame = '<path d="M10 10V190H590" fill="none" stroke="currentColor"/>'
            return f'<svg viewBox="0 0 600 200" width="600" fill="#0072b2" role="img">{frame}{points}</svg><p>{said}</p>'
    return ""


def _html(head: Iterable[str], rows: Iterable[Iterable[Any]]) -> str:
    def line(tag: str, cells: Iterable[Any]) -> str:
        return "<tr>" + "".join(f"<{tag}>{html.escape(_cell(cell))}</{tag}>" for cell in cells) + "</tr>"

    return "<table>" + line("th", head) + "".join(line("td", row) for row in rows) + "</table>"


def _cell(value: Any) -> str:
    if isinstance(value, (float, np.floating)):
        return f"{value:.6g}"
    return str(value) if isinstance(value, (str, np.generic)) else _short(value)


def _wrapped(value: Any) -> Any:
    if isinstance(value, Record):
        return value
    if isinstance(value, dict):
        return Record(value)
    if isinstance(value, list):
        return [_wrapped(one) for one in value]
    return value


def _column(values: Any) -> np.ndarray:
    if isinstance(values, np.ndarray):
        return values
    known = [one for one in values if one is not None]
    if not known or all(isinstance(one, (int, float)) and not isinstance(one, bool) for one in known):
        if len(known) < len(values) or not known:
            return np.array([np.nan if one is None else one for one in values], dtype=float)
        return np.array(values)
    if all(isinstance(one, bool) for one in values):
        return np.array(values, dtype=bool)
    if len(known) == len(values) and all(isinstance(one, str) for one in known):
        return np.array(values)
    column = np.empty(len(values), dtype=object)
    column[:] = values
    return column


def _same(one: Any, other: Any) -> bool:
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(_same, one, other))
    if np.shape(one) != np.shape(other):
        return False
    return bool(np.all((one == other) | ((one != one) & (other != other))))


def _plain(value: Any) -> Any:
    if isinstance(value, Record):
        return value.to_dict()
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, list):
        return [_plain(one) for one in value]
    return value


def _short(value: Any) -> str:
    if isinstance(value, np.ndarray):
        return f"<array {value.dtype} {value.shape}>"
    if isinstance(value, (Table, Grid)):
        return repr(value)
    if isinstance(value, Record):
        return f"Record({', '.join(value)})"
    if isinstance(value, list) and len(value) > 4:
        return f"[{len(value)} values]"
    return repr(value)
