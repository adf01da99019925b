"""Pictures and tables out of any view: who offers one, how it is taken, and what its PNG says.

A view that can be pictured says so once (``offer``) and gets the context menu for it, or adds the entries to its own
(``fill_menu``). What is asked for goes through ``requests`` to the window, which copies or saves it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

from PySide6.QtCore import QBuffer, QIODevice, QObject, QPoint, QSize, Qt, Signal
from PySide6.QtGui import QImage, QPainter
from PySide6.QtWidgets import QMenu, QWidget

SCALES = (1, 2, 4)
"""Pixels of the picture to a pixel of the screen."""
_DOTS_PER_METRE = 96.0 / 0.0254
_LARGEST_PX = 16_384
_ATTRIBUTE = "picture_offer"


@dataclass(frozen=True)
class PictureOptions:
    """How a picture is taken: its scale, with what is written over it or without, on its ground or on none."""

    scale: int = 1
    overlays: bool = True
    transparent: bool = False


Take = Callable[[PictureOptions], QImage]


@dataclass(frozen=True)
class Offer:
    """What a view offers.

    Attributes
    ----------
    widget : QWidget
        The view itself.
    name : str
        What file names end in, such as ``face``.
    title : str
        What people call the view.
    take : callable
        Takes the picture.
    overlays, transparent : bool
        Whether these options mean anything for it.
    table : callable, optional
        Returns its figures as rows of cells.
    ready : callable
        Says why there is nothing to picture just now; empty where there is.
    """

    widget: QWidget
    name: str
    title: str
    take: Take
    overlays: bool = False
    transparent: bool = False
    table: Callable[[], Sequence[Sequence[str]]] | None = None
    ready: Callable[[], str] = lambda: ""


class _Requests(QObject):
    asked = Signal(object, str)
    """An ``Offer`` and what is wanted of it: ``copy``, ``save`` or ``table``."""


requests = _Requests()


def offer(
    widget: QWidget,
    name: str,
    title: str,
    take: Take | None = None,
    *,
    overlays: bool = False,
    transparent: bool = False,
    table: Callable[[], Sequence[Sequence[str]]] | None = None,
    ready: Callable[[], str] | None = None,
    menu: bool = True,
) -> Offer:
    """Let a view be pictured; without ``take`` it is drawn as it stands. See ``Offer``.

    With ``menu`` the view gets a context menu for it; a view that has one of its own calls ``fill_menu`` there.
    """
    made = Offer(
        widget, name, title, take or partial(drawn, widget), overlays, transparent, table, ready or (lambda: "")
    )
    setattr(widget, _ATTRIBUTE, made)
    if menu:
        widget.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        widget.customContextMenuRequested.connect(partial(_pop_up, widget))
    return made


def offer_of(widget: QWidget | None) -> Offer | None:
    """Return what a widget, or the nearest one around it, offers."""
    while widget is not None:
        found = getattr(widget, _ATTRIBUTE, None)
        if isinstance(found, Offer):
            return found
        widget = widget.parentWidget()
    return None


def fill_menu(menu: QMenu, made: Offer) -> None:
    """Add the entries of an offer to a context menu."""
    why = made.ready()
    entries = [("Copy picture", "copy"), ("Save picture\u2026", "save")]
    if made.table is not None:
        entries.insert(0, ("Copy table", "table"))
    for text, wanted in entries:
        action = menu.addAction(text)
        action.setEnabled(not why)
        action.triggered.connect(partial(_ask, made, wanted))


def _ask(made: Offer, wanted: str, _checked: bool = False) -> None:
    requests.asked.emit(made, wanted)


def _pop_up(widget: QWidget, place: QPoint) -> None:
    made = offer_of(widget)
    if made is not None:
        pop_up(made, widget.mapToGlobal(place))


def pop_up(made: Offer, place: QPoint) -> None:
    """Show the menu of an offer at a global place."""
    menu = QMenu(made.widget)
    menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    fill_menu(menu, made)
    menu.popup(place)


def drawn(widget: QWidget, options: PictureOptions) -> QImage:
    """Return a widget as it draws itself, at a scale: letters and lines are drawn anew, not enlarged."""
    return canvas_for(widget.size(), widget.devicePixelRatioF(), options, partial(_render, widget))


def canvas_for(size: QSize, ratio: float, options: PictureOptions, paint: Callable[[QPainter], None]) -> QImage:
    """Return what ``paint`` draws over ``size`` pixels of the layout, ``ratio`` times scale pixels to each."""
    scale = options.scale * ratio
    scale = min(scale, _LARGEST_PX / max(size.width(), size.height(), 1))
    image = QImage(size * scale, QImage.Format.Format_ARGB32_Premultiplied)
    image.setDevicePixelRatio(scale)
    image.fill(Qt.GlobalColor.transparent)
    painter = QPainter(image)
    try:
        paint(painter)
    finally:
        painter.end()
    image.setDevicePixelRatio(1.0)
    return image


def _render(widget: QWidget, painter: QPainter) -> None:
    QWidget.render(widget, painter, QPoint())


def png(image: QImage, scale: int, texts: Mapping[str, str]) -> bytes:
    """Return a picture as PNG: printed at any scale it is as large as on a screen of 96 pixels an inch.

    Parameters
    ----------
    image : QImage
    scale : int
        Its pixels to a pixel of the screen.
    texts : mapping of str to str
        What its text chunks say, such as project, scan and view; empty ones are left out.
    """
    result = QImage(image)
    for which in (result.setDotsPerMeterX, result.setDotsPerMeterY):
        which(round(_DOTS_PER_METRE * scale))
    for key, text in texts.items():
        if text:
            result.setText(key, text)
    buffer = QBuffer()
    buffer.open(QIODevice.OpenModeFlag.WriteOnly)
    if not result.save(buffer, "PNG"):  # type: ignore[call-overload]
        raise OSError("the picture cannot be written as PNG")
    return bytes(buffer.data().data())


def tab_separated(rows: Sequence[Sequence[str]]) -> str:
    """Return rows of cells as spreadsheets take them: cells by tabs, rows by lines."""
    return "".join("\t".join(" ".join(cell.split()) for cell in row) + "\n" for row in rows)
