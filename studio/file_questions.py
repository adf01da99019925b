"""What is asked where a project is open elsewhere, or its file is not what it was."""

from __future__ import annotations

from PySide6.QtWidgets import QMessageBox, QWidget

Role = QMessageBox.ButtonRole


def ask_in_use(parent: QWidget, name: str, problem: str, can_take: bool) -> str:
    """Ask how to open a project that is open elsewhere: ``"copy"``, ``"take"`` or ``"cancel"``.

    To take it over is only offered where the other one is on another machine, of which nobody here can tell whether it
    is still alive.
    """
    text = f"{name} {problem}."
    more = "A copy has no name until you save it; what is saved there is not touched."
    if can_take:
        more += " Open it anyway only when you know that nobody works on it: who saves last replaces the other's work."
    choices = [("copy", "Open a &copy", Role.AcceptRole)]
    choices += [("take", "Open &anyway", Role.DestructiveRole)] if can_take else []
    return _ask(parent, "Project in use", text, more, choices)


def ask_changed_outside(parent: QWidget, name: str) -> str:
    """Ask what to do with a file that somebody else has written.

    Returns
    -------
    str
        ``"copy"``, ``"overwrite"``, ``"reload"`` or ``"cancel"``.
    """
    text = f"{name} was changed by another program since it was opened here."
    more = "Overwrite replaces those changes. Reload gives up the steps made here since it was saved."
    choices = [
        ("copy", "Save as a &copy...", Role.AcceptRole),
        ("overwrite", "&Overwrite", Role.DestructiveRole),
        ("reload", "&Reload", Role.DestructiveRole),
    ]
    return _ask(parent, "File changed outside", text, more, choices)


def ask_reload(parent: QWidget, name: str) -> bool:
    """Ask whether unsaved steps may be given up for what is in the file."""
    more = "The steps made here since it was saved are lost."
    return _ask(parent, "Reload", f"Reload {name}?", more, [("reload", "&Reload", Role.DestructiveRole)]) == "reload"


def _ask(parent: QWidget, title: str, text: str, more: str, choices: list[tuple[str, str, Role]]) -> str:
    """Ask with one button for each (answer, label, role), of which the first is the default, and Cancel."""
    box = QMessageBox(QMessageBox.Icon.Warning, title, text, QMessageBox.StandardButton.Cancel, parent)
    box.setInformativeText(more)
    buttons = {box.addButton(label, role): answer for answer, label, role in choices}
    box.setDefaultButton(next(iter(buttons)))
    box.setEscapeButton(box.button(QMessageBox.StandardButton.Cancel))
    box.exec()
    clicked = box.clickedButton()
    answer = next((answer for button, answer in buttons.items() if button is clicked), "cancel")
    box.deleteLater()
    return answer
