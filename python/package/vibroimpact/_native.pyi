"""The compiled part. ``Rig`` and ``presets`` are public; the functions behind them are called by this package only."""

from typing import Any

from ._records import Record, Table

__version__: str

class Rig:
    """A rig: masses, support, contact law, gap, and how its cart is moved.

    Parameters
    ----------
    source:
        A preset (``presets()`` lists them) or the path of a rig file (TOML, as ``host-sim rigs wires`` prints).
    **parameters:
        Any key of a rig file, units in the name: ``mass_kg=0.5``, ``gap_mm=1.0``, ``contact_law="hertz"``.

    Raises
    ------
    ValueError
        There is no such rig, or a key or a value cannot be used; the message names it.

    Notes
    -----
    The parameters are those of tables 3.1 to 3.3 of the chapter; each is an attribute (``rig.mass_kg``).
    """

    def __init__(self, source: str = "wires", /, **parameters: float | str) -> None: ...
    @staticmethod
    def from_toml(text: str, name: str = "rig", settings: list[str] = ...) -> Rig:
        """The rig in the text of a rig file."""
    def replace(self, **parameters: float | str) -> Rig:
        """The same rig with other parameters."""
    @property
    def name(self) -> str:
        """Its name, with what is set over it in brackets."""
    @property
    def parameters(self) -> dict[str, float | str]:
        """Every parameter by its key."""
    @property
    def natural_frequency_hz(self) -> float:
        """Natural frequency of the hammer on its support, Hz."""
    @property
    def weight_n(self) -> float:
        """The hammer's weight m g, N."""
    def to_toml(self) -> str:
        """A rig file with every parameter."""
    def __getattr__(self, key: str) -> Any: ...

def presets() -> list[str]:
    """The names of the built-in rigs."""

# Each of these takes all arguments of the function of its name, which checks the names.
def simulate(asked: dict[str, object]) -> Record: ...
def sweep(asked: dict[str, object]) -> Table: ...
def pick(asked: dict[str, object]) -> Record: ...
def map(asked: dict[str, object]) -> Record: ...
def basins(asked: dict[str, object]) -> Record: ...
def bifurcation(asked: dict[str, object]) -> Record: ...
def orbits(asked: dict[str, object]) -> Record: ...
def poincare(asked: dict[str, object]) -> Record: ...
def lyapunov(asked: dict[str, object]) -> Record: ...
def contact(asked: dict[str, object]) -> Table: ...
def drop(asked: dict[str, object]) -> Table: ...
def identify(asked: dict[str, object]) -> Record: ...
def compare(asked: dict[str, object]) -> Record: ...
def modes(asked: dict[str, object]) -> Record: ...
def drill(asked: dict[str, object]) -> Record: ...
def emulate(asked: dict[str, object]) -> Record: ...
def scenarios() -> list[tuple[str, str]]: ...
def trials(asked: dict[str, object]) -> Record: ...
