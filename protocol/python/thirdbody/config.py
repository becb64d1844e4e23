"""The data that a participant is launched with: common values, and its own keys."""

from __future__ import annotations

import difflib
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, Optional, Set

from .errors import ConfigurationError

_MISSING = object()


@dataclass(frozen=True)
class Setting:
    """Values for a participant that do not depend on its solver."""

    participant: str
    seed: int
    thickness_m: float
    threads: int
    #: Folder for fields; nothing is written when it is None.
    fields: Optional[Path]


class Config:
    """The keys below `participant.<name>.config`. A key that nothing reads is an error."""

    def __init__(self, values: Any, place: str = "") -> None:
        if not isinstance(values, dict):
            raise ConfigurationError(f"participant.config{place} must be a table")
        self._values: Dict[str, Any] = values
        self._place = place
        self._read: Set[str] = set()
        self._tables: Dict[str, Config] = {}

    def get(self, key: str, default: Any = _MISSING) -> Any:
        """The value of a key, or `default`."""
        self._read.add(key)
        value = self._values.get(key, default)
        if value is _MISSING:
            unread = [known for known in self._values if known not in self._read]
            meant = difflib.get_close_matches(key, unread, 1)
            hint = f"; does `{meant[0]}` stand for it?" if meant else ""
            raise ConfigurationError(f"participant.config{self._place}.{key} is missing{hint}")
        return value

    def table(self, key: str) -> Config:
        """A table of keys; empty if it is missing."""
        if key not in self._tables:
            self._tables[key] = Config(self.get(key, {}), f"{self._place}.{key}")
        return self._tables[key]

    def number(self, key: str, default: Any = _MISSING, *, above: Optional[float] = None) -> float:
        """A finite number, larger than `above` if given."""
        value = self.get(key, default)
        place = f"participant.config{self._place}.{key}"
        if isinstance(value, bool) or not isinstance(value, (int, float)) or value - value != 0:
            raise ConfigurationError(f"{place}: {value!r} is not a finite number")
        if above is not None and not value > above:
            raise ConfigurationError(f"{place}: {value!r} is not above {above}")
        return float(value)

    def integer(self, key: str, default: Any = _MISSING, *, above: Optional[int] = None) -> int:
        """A whole number, larger than `above` if given."""
        value = self.number(key, default, above=above)
        if value != int(value):
            raise ConfigurationError(f"participant.config{self._place}.{key}: {value!r} is not a whole number")
        return int(value)

    def require_all_read(self) -> None:
        """Refuses the first key that nothing has read."""
        for key in self._values:
            if key in self._read:
                continue
            near = difflib.get_close_matches(key, self._read, 1)
            known = f"did you mean `{near[0]}`?" if near else "known keys: " + (", ".join(sorted(self._read)) or "none")
            raise ConfigurationError(f"participant.config{self._place}.{key}: no such key; {known}")
        for table in self._tables.values():
            table.require_all_read()
