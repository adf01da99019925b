"""Every action of the window, declared once: text, menu, shortcut, icon, and why it cannot be used just now."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from PySide6.QtCore import QObject
from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import QWidget

from widgets import theme


@dataclass(frozen=True)
class ActionSpec:
    """What an action is called and where it is found.

    Attributes
    ----------
    id : str
        ``"file.save"``: menu or stage, then the deed.
    text : str
        With an ampersand before the key of the menu; three dots where a dialog follows.
    menu : str
        The menu it stands in; ``"File/Recent"`` is a submenu of File.
    shortcuts : tuple of str
        The first one is shown.
    tip : str
        A sentence on what it does; the text of the action where empty.
    group : int
        Actions of one menu with different numbers are kept apart by a line.
    """

    id: str
    text: str
    menu: str
    shortcuts: tuple[str, ...] = ()
    icon: str = ""
    tip: str = ""
    group: int = 0
    checkable: bool = False


A = ActionSpec
SPECS: tuple[ActionSpec, ...] = (
    A("file.new", "&New project", "File", ("Ctrl+N",), tip="Start an empty project"),
    A("file.open", "&Open project...", "File", ("Ctrl+O",), "folder", "Open a .qface project"),
    A("file.save", "&Save", "File", ("Ctrl+S",), tip="Save the project", group=1),
    A("file.save_as", "Save &as...", "File", ("Ctrl+Shift+S",), tip="Save the project under another name", group=1),
    A("file.restore", "Restore &unsaved work...", "File", (), "", "Show the work of sessions that ended unsaved", 1),
    A("scan.add", "Add s&cans...", "File", ("Ctrl+I",), "plus", "Open range images or meshes and add them", 2),
    A("scan.add_folder", "Add fol&der...", "File", ("Ctrl+Shift+O",), "", "Add all scans of a folder", 2),
    A("scan.sample", "Open sam&ple", "File", (), "", "Add the six scans of the bundled sample to the project", 2),
    A("scan.import", "Import &fiducials...", "File", ("Ctrl+Shift+I",), "", "Read fiducials of any format", 3),
    A("scan.export", "Ex&port fiducials...", "File", ("Ctrl+Shift+E",), "", "Write the placed fiducials", 3),
    A("scan.export_face", "&Export face...", "File", ("Ctrl+E",), "export", "Write the fitted face as GLB or OBJ", 3),
    A("basis.add_rig", "Open &rig...", "File", ("Ctrl+I",), "plus", "Open hand-sculpted shapes: GLB, OBJ, npz", 2),
    A("basis.add_motion", "Open &performance...", "File", ("Ctrl+Shift+I",), "", "Open markers, curves or a cache", 2),
    A("basis.sample", "Open sam&ple", "File", (), "", "Add the rig and the performance of the sample", 2),
    A("basis.relink", "&Find missing file...", "File", (), "", "Say where a rig or a performance lies now", 2),
    A("basis.export", "&Export basis...", "File", ("Ctrl+E",), "export", "Write the basis in use as GLB or npz", 3),
    A("basis.export_animated", "Export basis and perfor&mance...", "File", (), "", "Write an animated GLB", 3),
    A("basis.export_objects", "Export basis as &OBJ folder...", "File", (), "", "Write an OBJ a shape", 3),
    A("basis.export_weights", "Export &weights...", "File", (), "", "Write the curves of the basis in use as CSV", 3),
    A("basis.report", "Repor&t...", "File", (), "", "Write a PDF on the basis", 4),
    A("file.report", "Repor&t...", "File", (), "", "Write a PDF with an overview and a page for every scan", 4),
    A("file.quit", "&Quit", "File", ("Ctrl+Q",), tip="Close the window", group=9),
    A("edit.undo", "&Undo", "Edit", ("Ctrl+Z",), "undo", "Take the last step back"),
    A("edit.redo", "&Redo", "Edit", ("Ctrl+Shift+Z", "Ctrl+Y"), "redo", "Do the step again"),
    A("scan.unset", "Un&set fiducial", "Edit", ("Del",), "close", "Take the current fiducial off the picture", 1),
    A("scan.lock", "&Lock fiducial", "Edit", ("L",), "lock", "Keep the current fiducial from being moved", 1),
    A("scan.mirror", "&Mirror fiducials", "Edit", ("M",), "mirror", "Propose unset points from the other side", 1),
    A("scan.carry", "Carry o&ver", "Edit", ("C",), "copy", "Propose the points of another scan on this one", 1),
    A("scan.carry_to_all", "Carry to &all", "Edit", ("Shift+C",), "", "Propose this scan's points on all others", 1),
    A("basis.mirror", "&Mirror shape", "Edit", ("M",), "mirror", "Make the other side's shape of this one", 1),
    A("basis.split", "&Split left and right", "Edit", (), "", "Make a left and a right shape of one", 1),
    A("basis.combine", "&Combine shapes", "Edit", (), "", "Make one shape of those that are marked", 1),
    A("basis.duplicate", "D&uplicate shape", "Edit", ("Ctrl+D",), "copy", "Add a copy of the shape", 1),
    A("basis.rename", "&Rename shape...", "Edit", ("F2",), "", "Give the shape another name", 1),
    A("basis.remove", "Remo&ve shape", "Edit", ("Del",), "close", "Take the shape out of the rig", 1),
    A("basis.map_arkit", "Names by &ARKit", "Edit", (), "", "Name shapes as ARKit does, and say what is missing", 2),
    A("basis.map_facs", "Names by &FACS", "Edit", (), "", "Name shapes by action units, and say what is missing", 2),
    A("edit.preferences", "&Preferences...", "Edit", ("Ctrl+,",), "", "How the studio looks and behaves", 9),
    A("view.frame", "&Frame", "View", ("F",), "fit-view", "Bring the whole picture and face into view"),
    A("view.frame_selected", "Frame f&iducial", "View", ("Shift+F",), "", "Near the current fiducial, or go back"),
    A("view.wire", "&Wireframe", "View", ("W",), "wire", "Show the mesh over the face", 1, True),
    A("view.points", "Scan &points", "View", ("P",), "points", "Show the scan's points around the face", 1, True),
    A("view.heat", "&Heatmap", "View", ("H",), "heatmap", "Show the distance to the scan", 1, True),
    A("view.loupe", "&Loupe", "View", ("Z",), "loupe", "Keep the loupe in sight", 1, True),
    A("basis.side", "Side &by side", "View", (), "", "Show hand and quasi-eigen shape beside each other", 1, True),
    A("basis.overlay", "O&verlay", "View", (), "", "Show both shapes in one place", 1, True),
    A("basis.wipe", "W&ipe", "View", (), "", "Show both shapes in one place, parted by a line", 1, True),
    A("basis.grid", "&Grid", "View", (), "", "Show all shapes at once", 1, True),
    A("basis.clip_heat", "&Error over the clip", "View", (), "", "Show each vertex's error over the clip", 1, True),
    A("basis.pca", "&PCA", "View", (), "", "Show the reconstruction by the PCA axes too", 1, True),
    A("view.textured", "&Textured", "View", ("T",), "", "Show the scan's colour on the face, or clay", 1, True),
    A("view.front", "Fron&t", "View", ("Ctrl+1",), "", "Look at the face from the front", 2),
    A("view.left", "&Left side", "View", ("Ctrl+2",), "", "Look at the subject's left side", 2),
    A("view.right", "&Right side", "View", ("Ctrl+3",), "", "Look at the subject's right side", 2),
    A("view.three_quarter", "Three-&quarter", "View", ("Ctrl+4",), "", "Look from between front and side", 2),
    A("view.top", "T&op", "View", ("Ctrl+5",), "", "Look at the head from above", 2),
    A("view.back", "&Back", "View", ("Ctrl+6",), "", "Look at the face from behind", 2),
    A("view.below", "From belo&w", "View", (), "", "Look up at the face from below the chin", 2),
    A("view.orthographic", "Ortho&graphic", "View", ("O",), "", "Without perspective, or with it", 2, True),
    A("view.copy_picture", "&Copy picture", "View", ("Ctrl+Shift+C",), "copy", "Copy the view at the mouse", 4),
    A("view.picture", "&Save picture...", "View", (), "camera", "Save the view at the mouse as PNG", 4),
    A("view.dark", "&Dark theme", "View", (), "", "Dark surfaces, or light ones", 3, True),
    A("view.larger", "La&rger text", "View", ("Ctrl+=", "Ctrl++"), "", "Larger letters, rows and icons", 3),
    A("view.smaller", "S&maller text", "View", ("Ctrl+-",), "", "Smaller letters, rows and icons", 3),
    A("view.usual", "Text at &100 %", "View", ("Ctrl+0",), "", "Letters, rows and icons as they were made", 3),
    A("scan.fit", "&Fit", "Scan", ("Ctrl+Return", "Ctrl+Enter"), "", "Fit the template to the current scan"),
    A("scan.fit_all", "Fit &all", "Scan", ("Ctrl+Shift+Return",), "", "Fit every scan whose fiducials are ready"),
    A("scan.batch", "Fit all with &options...", "Scan", (), "", "Fit many scans, write their faces and a report"),
    A("scan.limits", "&Limits...", "Scan", (), "", "Say what passes, warns and fails, for the face and its regions"),
    A("scan.next", "&Next unfinished", "Scan", ("N",), "", "Go to the next fiducial to place or confirm", 1),
    A("scan.confirm", "&Confirm", "Scan", ("Return", "Enter"), "", "Accept the current proposed fiducial", 1),
    A("scan.confirm_all", "Confirm &all", "Scan", ("Shift+Return", "Shift+Enter"), "", "Accept every proposal", 1),
    A("scan.skip", "&Skip", "Scan", ("S",), "", "Leave the current fiducial out of this scan", 1),
    A(
        "scan.scheme",
        "Fid&ucial scheme...",
        "Scan",
        ("Ctrl+Shift+F",),
        "",
        "Choose, change or make a set of points",
        2,
    ),
    A("scan.copy_command", "Cop&y as command", "Scan", (), "", "Copy the command line that makes the same fit", 2),
    A(
        "scan.place_camera",
        "Place ca&mera...",
        "Scan",
        ("Ctrl+M",),
        "camera",
        "Turn the mesh before its camera",
        2,
    ),
    A("scan.rename", "&Rename scan...", "Scan", ("F2",), "", "Give the current scan another name", 2),
    A("scan.remove", "Re&move scan", "Scan", (), "", "Take the current scan out of the project", 2),
    A("basis.analyse", "&Make basis", "Basis", ("Ctrl+Return", "Ctrl+Enter"), "", "Project the shapes again"),
    A("basis.next", "&Next to look at", "Basis", ("N",), "", "Go to the next shape unlike its hand shape"),
    A("basis.to_hand", "To &hand", "Basis", ("Ctrl+Left",), "", "Use the hand shape as it was sculpted", 1),
    A("basis.to_quasi", "To &quasi-eigen", "Basis", ("Ctrl+Right",), "", "Use the quasi-eigen shape altogether", 1),
    A("basis.play", "&Play", "Basis", ("K",), "", "Play the performance, or stop", 2),
    A("basis.frame_back", "Frame &back", "Basis", (",",), "", "Go one frame back", 2),
    A("basis.frame_on", "Frame &on", "Basis", (".",), "", "Go one frame on", 2),
    A("basis.worst", "Worst &frame", "Basis", ("E",), "", "Go to the next of the worst frames", 2),
    A("basis.choose_hand", "Choose hand &rig...", "Basis", (), "", "Choose which rig's shapes are projected", 3),
    A("basis.choose_motion", "&Choose performance...", "Basis", (), "", "Choose what the basis is measured by", 3),
    A("basis.motion_settings", "Performance &settings...", "Basis", ("Ctrl+M",), "", "Unit, axes and markers", 3),
    A("basis.remove_rig", "Remove rig", "Basis", (), "", "Take the hand-sculpted rig out of the project", 4),
    A("basis.remove_motion", "Remove performance", "Basis", (), "", "Take the performance out of the project", 4),
    A("basis.copy_command", "Cop&y as command", "Basis", (), "", "Copy the command line that makes this basis", 5),
    A("window.next_zone", "&Next zone", "Window", ("F6", "Ctrl+Tab"), "", "Give the keys to the next dock or view", 8),
    A("window.last_zone", "Pre&vious zone", "Window", ("Shift+F6", "Ctrl+Shift+Tab"), "", "Go back one zone", 8),
    A("window.save_layout", "&Save layout as...", "Window", (), "", "Keep this arrangement under a name", 10),
    A("window.reset", "&Reset layout", "Window", (), "", "Put every dock back to its place", 10),
    A("help.overview", "&Shortcuts and commands", "Help", ("F1", "Ctrl+Shift+P", "Ctrl+K"), tip="Find any action"),
    A("help.about", "&About Quasiface Studio", "Help", tip="Version and licences"),
)

MENUS = ("File", "Edit", "View", "Scan", "Basis", "Window", "Help")
ELSEWHERE = "it belongs to another stage"

Reason = Callable[[], str]
"""Says why an action cannot be used just now, in a few words; empty when it can."""


@dataclass
class _Deed:
    """What an action does in one stage, or in all of them, and what it is called there where that is something else."""

    run: Callable[..., object]
    reason: Reason | None
    text: str = ""
    tip: str = ""
    checked: bool = False


class Actions(QObject):
    """The actions of one window by id; what one does may depend on the stage in view.

    An action that has no deed in the stage in view is neither seen nor reached by its keys.

    Parameters
    ----------
    window : QWidget
        Owns the actions and their shortcuts.

    Attributes
    ----------
    owner : str
        The stage whose deeds are being bound; empty for deeds that every stage has.
    """

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self.owner = ""
        self._stage = ""
        self._window = window
        self._specs = {spec.id: spec for spec in SPECS}
        self._deeds: dict[tuple[str, str], _Deed] = {}
        self._keys: dict[str, tuple[str, ...]] = {}
        self._actions = {spec.id: self._made(spec) for spec in SPECS}
        for spec in SPECS:
            self._describe(spec.id, "")

    def _made(self, spec: ActionSpec) -> QAction:
        action = QAction(spec.text, self._window)
        action.setObjectName(spec.id)
        action.setShortcuts([QKeySequence(text) for text in spec.shortcuts])
        action.setCheckable(spec.checkable)
        action.setAutoRepeat(spec.id in ("edit.undo", "edit.redo") or spec.id.endswith(".next"))
        action.setVisible(False)
        if spec.checkable:
            action.toggled.connect(lambda on: self._toggle(spec.id, on))
        else:
            action.triggered.connect(lambda _checked=False: self._run(spec.id))
        self._window.addAction(action)
        return action

    def bind(
        self, action_id: str, run: Callable[..., object], reason: Reason | None = None, *, text: str = "", tip: str = ""
    ) -> QAction:
        """Give a declared action its deed in the stage of ``owner``; a checkable one passes whether it is checked.

        ``text`` and ``tip`` stand in that stage for the declared ones.
        """
        self._deeds[self._specs[action_id].id, self.owner] = _Deed(run, reason, text, tip)
        self._name(action_id)
        return self._actions[action_id]

    def _name(self, action_id: str) -> None:
        """Show an action where it has a deed, under the name it has there."""
        action, deed = self._actions[action_id], self._deed(action_id)
        action.setVisible(deed is not None)
        action.setText(self.text(action_id))
        self._describe(action_id, str(action.property("why") or ""))

    def text(self, action_id: str) -> str:
        """Return what an action is called in the stage in view."""
        deed = self._deed(action_id)
        return (deed.text if deed is not None else "") or self._specs[action_id].text

    def tip(self, action_id: str) -> str:
        """Return the sentence on what an action does in the stage in view; empty where its text says it."""
        deed = self._deed(action_id)
        return (deed.tip if deed is not None else "") or self._specs[action_id].tip

    @property
    def stage(self) -> str:
        """The id of the stage in view."""
        return self._stage

    def is_here(self, action_id: str) -> bool:
        """Return whether an action has a deed in the stage in view."""
        return self._deed(action_id) is not None

    def has_deed(self, action_id: str) -> bool:
        """Return whether an action has a deed in any stage that was made."""
        return any(known == action_id for known, _ in self._deeds)

    def start(self, action_id: str, checked: bool) -> None:
        """Let a checkable action that has just been bound begin like this, without doing its deed."""
        self._deeds[action_id, self.owner].checked = checked
        if self.owner in ("", self._stage):
            self._mark(self._actions[action_id], checked)

    def mark(self, action_id: str, checked: bool) -> None:
        """Show a checkable action of the stage in view as it is, without doing its deed."""
        deed = self._deed(action_id)
        if deed is not None:
            deed.checked = checked
            self._mark(self._actions[action_id], checked)

    def set_stage(self, stage_id: str) -> None:
        """Let the actions do what they do in another stage."""
        self._stage = stage_id
        for action_id, action in self._actions.items():
            deed = self._deed(action_id)
            self._name(action_id)
            if deed is not None and action.isCheckable():
                self._mark(action, deed.checked)

    @staticmethod
    def _mark(action: QAction, checked: bool) -> None:
        action.blockSignals(True)
        action.setChecked(checked)
        action.blockSignals(False)
        action.changed.emit()

    def _deed(self, action_id: str) -> _Deed | None:
        return self._deeds.get((action_id, self._stage)) or self._deeds.get((action_id, ""))

    def _run(self, action_id: str) -> None:
        deed = self._deed(action_id)
        if deed is not None:
            deed.run()

    def _toggle(self, action_id: str, on: bool) -> None:
        deed = self._deed(action_id)
        if deed is not None:
            deed.checked = on
            deed.run(on)

    def set_shortcuts(self, action_id: str, shortcuts: tuple[str, ...] | None = None) -> None:
        """Give an action other shortcuts than the declared ones, or those again where left out."""
        self._keys.pop(action_id, None)
        if shortcuts is not None:
            self._keys[action_id] = shortcuts
        action = self._actions[action_id]
        action.setShortcuts([QKeySequence(text) for text in self.shortcuts(action_id)])
        self._describe(action_id, str(action.property("why") or ""))

    def shortcuts(self, action_id: str) -> tuple[str, ...]:
        """Return the shortcuts that an action has now, the first one shown."""
        return self._keys.get(action_id, self._specs[action_id].shortcuts)

    def __getitem__(self, action_id: str) -> QAction:
        return self._actions[action_id]

    def __contains__(self, action_id: object) -> bool:
        return action_id in self._actions

    def in_menu(self, menu: str) -> list[tuple[int, QAction]]:
        """Return the actions of a menu with their group numbers, in declared order."""
        return [(spec.group, self._actions[spec.id]) for spec in SPECS if spec.menu == menu]

    def refresh(self) -> None:
        """Ask every action whether it can be used, and say so in its tooltip."""
        for action_id, action in self._actions.items():
            deed = self._deed(action_id)
            if deed is None:
                why = ELSEWHERE
            else:
                why = deed.reason() if deed.reason is not None else ""
            if action.isEnabled() != (not why) or action.property("why") != why:
                action.setEnabled(not why)
                self._describe(action_id, why)

    def refresh_icons(self) -> None:
        """Draw the icons anew in the colours of the current theme."""
        for action_id, action in self._actions.items():
            name = self._specs[action_id].icon
            if name:
                action.setIcon(theme.icon(name, "text"))

    def shortcut_text(self, action_id: str) -> str:
        """Return the first shortcut of an action as the platform writes it."""
        return shortcut_text(self.shortcuts(action_id)[:1])

    def _describe(self, action_id: str, why: str) -> None:
        action = self._actions[action_id]
        keys = shortcut_text(self.shortcuts(action_id)[:1])
        first = (self.tip(action_id) or self.text(action_id).replace("&", "")) + (f" ({keys})" if keys else "")
        action.setProperty("why", why)
        action.setToolTip(f"{first}\nNot now: {why}" if why else first)
        action.setStatusTip(f"{first.split(' (')[0]} - not now: {why}" if why else first)


def shortcut_text(shortcuts: tuple[str, ...]) -> str:
    """Return the first shortcut as the platform writes it, with Enter for the key that says so; empty without one."""
    if not shortcuts:
        return ""
    text = QKeySequence(shortcuts[0]).toString(QKeySequence.SequenceFormat.NativeText)
    return text.replace("Return", "Enter")
