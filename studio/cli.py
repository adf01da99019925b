"""The command line: which commands there are, and how their failures are told. Loads no Qt but for ``studio``.

Exit codes: 0 done; 2 the input is wrong, with one line on stderr that says which file or value, what is wrong and what
to do; 1 our own fault, with a crash report.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from pathlib import Path

from cyclopts import App, CycloptsError

from studio.output import Json, remark

_DISPLAYS = ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM")
DONE, OUR_FAULT, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130


def _version() -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("quasiface-studio")
    except PackageNotFoundError:
        return "unknown (not installed)"


app = App(
    name="quasiface",
    help="From face scans, sculpted shapes and performances to blendshape bases. Alone it opens the studio.",
    version=_version,
    exit_on_error=False,
    print_error=False,
    suppress_keyboard_interrupt=False,
    result_action="return_value",
)
scan = App(name="scan", help="Look at a scan, or fit the face template to it.")
app.command(scan)
# Named by text, so that help is there before numpy and the image readers are loaded.
scan.command("studio.scan.cli:info", name="info", help="Say what a scan holds: size, missing pixels, spikes, bounds.")
scan.command("studio.scan.cli:fit", name="fit", help="Fit the face template to a scan and write GLB or OBJ.")


@app.default
def _open() -> int:
    return studio()


@app.command
def studio(project: Path | None = None, /) -> int:
    """Open the studio.

    Parameters
    ----------
    project : Path
        A project file (.qface) to open.
    """
    from engine.errors import InputError

    if project is not None and not project.is_file():
        raise InputError(str(project), "there is no such file", "check the name and the folder")
    if sys.platform.startswith("linux") and not any(map(os.environ.get, _DISPLAYS)):
        remedy = "start it from a desktop, or use quasiface demo and quasiface scan fit, which need none"
        raise InputError("studio", "there is no display to open a window on", remedy)
    try:
        from studio.app import run
    except ImportError as error:
        if (error.name or "").startswith(("studio", "widgets", "engine")):
            raise
        raise InputError("studio", f"no window can be opened ({error})", "install what the README names") from error

    return run(project)


@app.command
def demo(*, out: Path = Path("quasiface-demo"), as_json: Json = False) -> int:
    """Go the whole way on the bundled sample, without a display: faces, project, report and plates.

    Parameters
    ----------
    out : Path
        Folder that everything is written to; made when it is not there.
    """
    from studio.demo import run

    return run(out, as_json)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code; ``arguments`` are those of the process when left out."""
    try:
        code = app(list(sys.argv[1:] if arguments is None else arguments))
        sys.stdout.flush()
        return code if isinstance(code, int) else DONE
    except CycloptsError as error:
        return _refuse(_argument_problem(error))
    except ValueError as error:
        from engine.errors import InputError

        if not isinstance(error, InputError):
            return _crash(error)
        return _refuse(str(error))
    except BrokenPipeError:
        # Whoever read our output has had enough; what is still buffered must not raise again at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE
    except KeyboardInterrupt:
        return INTERRUPTED
    except Exception as error:
        return _crash(error)


def _refuse(text: str) -> int:
    remark(text)
    return BAD_INPUT


def _argument_problem(error: CycloptsError) -> str:
    """Return what is wrong with the arguments in one line, with the help to look at."""
    from pydantic import ValidationError

    command = " ".join(("quasiface", *(error.command_chain or ())))
    if isinstance(error.__cause__, ValidationError):
        first = error.__cause__.errors(include_url=False, include_context=False)[0]
        option = "--" + "-".join(str(part) for part in first["loc"]).replace("_", "-")
        text = f"{option} {first['input']!r}: {first['msg'][:1].lower()}{first['msg'][1:]}"
    else:
        text = str(error).rstrip(". ")
    return f"{text}; see {command} --help"


def _crash(error: BaseException) -> int:
    from studio.crash_report import write_report

    try:
        place = f"a report is in {write_report(error)}"
    except OSError as failure:
        place = f"no report could be written ({failure.strerror})"
    remark(f"quasiface failed by a fault of its own: {type(error).__name__}: {error}; {place}")
    return OUR_FAULT
