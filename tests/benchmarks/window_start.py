"""One start of the studio: seconds from the moment given to first paint and 3-D, and the idle CPU after.

Beside each the processor time of the process, which a busy machine changes less.
"""

from __future__ import annotations

import json
import sys
import time

import psutil


def main(started: float) -> None:
    from PySide6.QtCore import QTimer

    from studio.app import application, make_window

    app = application()
    window = make_window()
    found: dict[str, float] = {}
    process = psutil.Process()

    def note(name: str) -> None:
        found.setdefault(f"{name}_s", time.time() - started)
        found.setdefault(f"{name}_cpu_s", time.process_time())

    def settle() -> None:
        process.cpu_percent()
        QTimer.singleShot(3000, finish)

    def finish() -> None:
        found["idle_cpu_percent"] = process.cpu_percent()
        print(json.dumps(found), flush=True)
        window.close()
        app.quit()

    def scene() -> None:
        note("scene")
        QTimer.singleShot(1500, settle)

    window.painted.connect(lambda: note("painted"))
    window.stage.centre.views.ready.connect(scene)
    window.resize(1440, 900)
    window.show()
    QTimer.singleShot(60_000, app.quit)
    sys.exit(app.exec())


if __name__ == "__main__":
    main(float(sys.argv[1]))
