"""Copies and saves pictures and tables of any view of the window."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Qt
from PySide6.QtGui import QCursor, QGuiApplication, QImage
from PySide6.QtWidgets import QApplication, QWidget

from engine.errors import InputError
from engine.files.atomic import atomic_write
from studio.actions import Actions
from widgets.parts import picture
from widgets.parts.picture import Offer, PictureOptions
from widgets.parts.picture_dialog import PictureDialog

if TYPE_CHECKING:
    from studio.main_window import MainWindow


class Pictures(QObject):
    """Answers what the views of a window ask for.

    Parameters
    ----------
    window : MainWindow
        Its stage in view says what is pictured (``subject``), and which view is taken where neither the mouse nor the
        keys are in one (``usual_view``).
    """

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self._window = window
        picture.requests.asked.connect(self._answer)

    def close(self) -> None:
        """Answer no more."""
        picture.requests.asked.disconnect(self._answer)

    def bind(self, actions: Actions) -> None:
        """Give the two actions their deeds."""
        actions.bind("view.copy_picture", lambda: self._act("copy"), self._reason)
        actions.bind("view.picture", lambda: self._act("save"), self._reason)

    def here(self) -> Offer | None:
        """Return what the view under the mouse offers, else the one with the keys, else the usual one."""
        for widget in (QApplication.widgetAt(QCursor.pos()), QApplication.focusWidget(), self._window.stage.usual_view):
            found = picture.offer_of(widget)
            if found is not None and self._is_ours(found.widget) and not found.ready():
                return found
        return None

    def copy(self, made: Offer, options: PictureOptions | None = None) -> None:
        """Put a picture of a view on the clipboard."""
        QGuiApplication.clipboard().setImage(self._take(made, options or PictureOptions()))
        self._window.message.tell("info", f"Copied the {made.title} as a picture")

    def save(self, made: Offer, path: Path, options: PictureOptions) -> None:
        """Write a picture of a view as PNG.

        Raises
        ------
        InputError
            Where the file cannot be written.
        """
        texts = {
            "Title": " ".join(filter(None, (self._window.stage.subject, made.title))),
            "Project": self._window.session.name,
            "Subject": self._window.stage.subject,
            "View": made.title,
            "Software": "Quasiface Studio",
        }
        data = picture.png(self._take(made, options), options.scale, texts)
        with atomic_write(path) as file:
            file.write(data)
        self._window.settings["files/folder"] = str(path.parent)
        self._window.message.tell("info", f"Wrote {path}")

    def ask(self, made: Offer) -> PictureDialog:
        """Open the dialog that saves a picture of a view, and return it."""
        dialog = PictureDialog(made, self._proposed(made), self._window)

        def save(path: Path, options: PictureOptions) -> None:
            try:
                self.save(made, path, options)
            except (InputError, OSError) as error:
                dialog.tell(str(error))
            else:
                dialog.accept()

        def copy(options: PictureOptions) -> None:
            self.copy(made, options)
            dialog.accept()

        dialog.save_requested.connect(save)
        dialog.copy_requested.connect(copy)
        dialog.open()
        return dialog

    def _proposed(self, made: Offer) -> Path:
        project, folder = self._window.session.project.path, Path(self._window.settings["files/folder"] or ".")
        if not folder.is_dir() or str(folder) == ".":
            folder = project.parent if project is not None else Path.home()
        name = "_".join(filter(None, (self._window.stage.subject or (project.stem if project else ""), made.name)))
        return folder / f"{name}.png"

    def _take(self, made: Offer, options: PictureOptions) -> QImage:
        QApplication.setOverrideCursor(Qt.CursorShape.WaitCursor)
        try:
            return made.take(options)
        finally:
            QApplication.restoreOverrideCursor()

    def _act(self, wanted: str) -> None:
        found = self.here()
        if found is not None:
            self._answer(found, wanted)

    def _reason(self) -> str:
        return "" if self.here() is not None else "there is no view to picture yet"

    def _is_ours(self, widget: QWidget | None) -> bool:
        while widget is not None and widget is not self._window:
            widget = widget.parentWidget()
        return widget is self._window

    def _answer(self, made: Offer, wanted: str) -> None:
        if not self._is_ours(made.widget):
            return
        if made.ready():
            self._window.message.tell("info", f"Not now: {made.ready()}")
        elif wanted == "copy":
            self.copy(made)
        elif wanted == "table" and made.table is not None:
            QGuiApplication.clipboard().setText(picture.tab_separated(made.table()))
            self._window.message.tell("info", f"Copied the {made.title} as a table")
        elif wanted == "save":
            self.ask(made)
