"""What the studio did and said: one stream of lines from Python's logging, kept in memory and on disk. No Qt."""

from __future__ import annotations

import contextlib
import logging
import logging.handlers
import threading
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

import platformdirs

KEPT_LINES = 4000
LONGEST_LINE = 4000
FILE_BYTES, FILE_COUNT = 1_000_000, 3
studio_log = logging.getLogger("studio")
"""Where the studio itself writes."""


@dataclass(frozen=True)
class LogLine:
    """One line: when, how grave (`logging.INFO`...), who says it, what; ``text`` may hold line breaks."""

    time: datetime
    level: int
    source: str
    text: str

    @property
    def word(self) -> str:
        """The level as a word: info, warning or error."""
        return "error" if self.level >= logging.ERROR else "warning" if self.level >= logging.WARNING else "info"

    def __str__(self) -> str:
        return f"{self.time:%H:%M:%S}.{self.time.microsecond // 1000:03d}  {self.word:<7}  {self.source}: {self.text}"


class LogRing(logging.Handler):
    """Keeps the last lines; ``listener`` hears every new one, in whichever thread it was said."""

    def __init__(self, keep: int = KEPT_LINES) -> None:
        super().__init__(logging.DEBUG)
        self._lines: deque[LogLine] = deque(maxlen=keep)
        self._gate = threading.Lock()
        self.listener: Callable[[LogLine], None] | None = None

    def emit(self, record: logging.LogRecord) -> None:
        """Keep a record as a line."""
        try:
            text = record.getMessage()
            if record.exc_info:
                text += "\n" + logging.Formatter().formatException(record.exc_info)
            when = datetime.fromtimestamp(record.created).astimezone()
            line = LogLine(when, record.levelno, record.name, text[:LONGEST_LINE])
            with self._gate:
                self._lines.append(line)
            if self.listener is not None:
                self.listener(line)
        except Exception:
            self.handleError(record)

    @property
    def lines(self) -> tuple[LogLine, ...]:
        """What is kept, the oldest first."""
        with self._gate:
            return tuple(self._lines)

    def clear(self) -> None:
        """Forget every line."""
        with self._gate:
            self._lines.clear()


ring = LogRing()
"""The lines of this process."""


def log_folder() -> Path:
    """Return the folder that log files of this user go to."""
    return platformdirs.user_log_path("quasiface", appauthor=False)


def attach() -> None:
    """Let the ring hear everything that is said by logging, from information upwards by the studio itself."""
    studio_log.setLevel(logging.INFO)
    if ring not in logging.getLogger().handlers:
        logging.getLogger().addHandler(ring)


def detach() -> None:
    """Let the ring hear nothing more."""
    logging.getLogger().removeHandler(ring)


@contextlib.contextmanager
def to_file(folder: Path | None = None) -> Iterator[Path]:
    """Write the same lines to ``studio.log`` in the user's log folder while the context lasts; yields the file."""
    path = (folder or log_folder()) / "studio.log"
    handler: logging.Handler | None = None
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handler = logging.handlers.RotatingFileHandler(path, "a", FILE_BYTES, FILE_COUNT, "utf-8", delay=True)
        handler.setFormatter(logging.Formatter("%(asctime)s %(levelname)-7s %(name)s: %(message)s"))
        logging.getLogger().addHandler(handler)
    except OSError as error:
        studio_log.warning("the log file cannot be written (%s)", error.strerror)
    logging.captureWarnings(True)
    try:
        yield path
    finally:
        logging.captureWarnings(False)
        if handler is not None:
            logging.getLogger().removeHandler(handler)
            handler.close()


def tail(count: int = 60) -> tuple[str, ...]:
    """Return the last lines as text."""
    return tuple(str(line) for line in ring.lines[-count:])
