"""The command line: which commands there are, and how their failures are told. Loads no Qt but for ``studio``.

Exit codes: 0 done; 2 the input is wrong, with one line on stderr that says which file or value, what is wrong and what
to do; 1 our own fault, with a crash report, or output that cannot be printed.
"""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from cyclopts import App, CycloptsError

from studio.output import Json, print_result, remark

_DISPLAYS = ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM")
_FULL = (errno.ENOSPC, errno.EFBIG, errno.EIO, getattr(errno, "EDQUOT", errno.ENOSPC))
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
scan.command("studio.scan.view_cli:view", name="view", help="Look at a mesh with a virtual camera and write a scan.")

scheme = App(name="scheme", help="Look at a fiducial scheme.")
app.command(scheme)
scheme.command("studio.scan.scheme_cli:check", name="check", help="Say what a scheme holds and whether it fits.")
fiducials = App(name="fiducials", help="Look at a file of landmarks, or turn it into another.")
app.command(fiducials)
fiducials.command("studio.scan.fiducial_cli:info", name="info", help="Say what a file of landmarks holds.")
fiducials.command("studio.scan.carry_cli:carry", name="carry", help="Carry the fiducials of one scan to others.")
fiducials.command(
    "studio.scan.fiducial_cli:convert", name="convert", help="Turn landmarks of other tools into fiducials, or back."
)
basis = App(name="basis", help="Make a basis of what a performance does, and measure how well it reproduces it.")
app.command(basis)
basis.command("studio.basis.cli:pca", name="pca", help="Find the principal axes of a performance.")
basis.command("studio.basis.cli:project", name="project", help="Project hand-sculpted shapes onto a performance.")
basis.command("studio.basis.cli:solve", name="solve", help="Find the weights that reproduce a performance.")
app.command("studio.batch.cli:batch", name="batch", help="Fit many scans: those of a jobs file, or all of a project.")
app.command("studio.report.cli:report", name="report", help="Write a PDF report: an overview, a page for every scan.")


@app.default
def _open(*, as_json: Json = False) -> int:
    return studio(as_json=as_json)


@app.command
def studio(project: Path | None = None, /, *, as_json: Json = False) -> int:
    """Open the studio. With --json, say when it is closed which project was opened and the exit code.

    Parameters
    ----------
    project : Path
        A project file (.qface) to open.
    """
    from engine.errors import InputError
    from engine.files.source import kind_of

    if project is not None and kind_of(project) != "file":
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

    code = run(project)
    if as_json:
        print_result({"project": project, "exit_code": code}, True)
    return code


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
        _drop_output()
        return DONE
    except OSError as error:
        # What we write to files becomes an InputError that names the file; without a name it is the output itself.
        if error.errno not in _FULL or error.filename is not None:
            return _crash(error)
        _drop_output()
        remark(f"the output cannot be written ({error.strerror}); make room or print it elsewhere")
        return OUR_FAULT
    except KeyboardInterrupt:
        return INTERRUPTED
    except Exception as error:
        return _crash(error)


def _drop_output() -> None:
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _refuse(text: str) -> int:
    remark(text)
    return BAD_INPUT


def _argument_problem(error: CycloptsError) -> str:
    """Return what is wrong with the arguments in one line, with the help to look at."""
    from pydantic import ValidationError

    from engine.files.complaint import first_complaint

    command = " ".join(("quasiface", *(error.command_chain or ())))
    if isinstance(error.__cause__, ValidationError):
        complaint = first_complaint(error.__cause__)
        option = "--" + "-".join(complaint.place).replace("_", "-")
        text = f"{option} {complaint.given!r}: {complaint.problem}"
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
