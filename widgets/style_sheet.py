"""The small style sheet that gives Fusion's controls our sizes, radii and lines."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from widgets.theme import Theme


def style_sheet(theme: Theme, icons: str) -> str:
    """Return the application's style sheet; ``icons`` is the folder of our SVG files with forward slashes."""
    t = theme
    tone = theme.name
    return f"""
QWidget {{ font-size: 12px; }}
QMainWindow, QMainWindow::separator {{ background: {t.window}; }}
QMainWindow::separator {{ width: 4px; height: 4px; }}
QMainWindow::separator:hover {{ background: {t.accent}; }}
QSplitter::handle {{ background: {t.window}; image: none; }}
QSplitter::handle:hover {{ background: {t.accent}; }}
QToolTip {{ background: {t.raised}; color: {t.text}; border: 1px solid {t.line}; padding: 4px 6px; }}

QPushButton {{ background: {t.raised}; color: {t.text}; border: 1px solid {t.line}; border-radius: 4px;
    padding: 0 10px; min-height: 22px; max-height: 22px; }}
QPushButton:hover {{ border-color: {t.dim}; }}
QPushButton:pressed {{ background: {t.segment_on}; }}
QPushButton:disabled {{ color: {t.missing}; background: {t.panel}; }}
QPushButton:focus {{ border-color: {t.accent}; }}
QPushButton[primary="true"] {{ background: {t.accent}; color: {t.on_accent}; border-color: {t.accent};
    font-weight: 600; }}
QPushButton[primary="true"]:hover {{ background: #f09f42; }}
QPushButton[primary="true"]:focus {{ border-color: {t.text}; }}
QPushButton[primary="true"]:disabled {{ background: {t.panel}; color: {t.missing}; border-color: {t.line}; }}

QToolButton {{ background: transparent; color: {t.text}; border: 1px solid transparent; border-radius: 4px;
    padding: 0; }}
QToolButton[raised="true"] {{ background: {t.raised}; }}
QToolButton:hover {{ background: {t.raised}; }}
QToolButton:checked {{ background: {t.raised}; }}
QToolButton:pressed {{ background: {t.segment_on}; }}
QToolButton:focus {{ border-color: {t.accent}; }}
QToolButton::menu-indicator {{ image: none; }}

QLineEdit, QSpinBox, QDoubleSpinBox, QComboBox {{ background: {t.input}; color: {t.text}; border: 1px solid {t.line};
    border-radius: 4px; padding: 0 6px; min-height: 20px; max-height: 20px;
    selection-background-color: {t.accent}; selection-color: {t.on_accent}; }}
QLineEdit:hover, QSpinBox:hover, QDoubleSpinBox:hover, QComboBox:hover {{ border-color: {t.dim}; }}
QLineEdit:focus, QSpinBox:focus, QDoubleSpinBox:focus, QComboBox:focus {{ border-color: {t.accent}; }}
QLineEdit:disabled, QSpinBox:disabled, QDoubleSpinBox:disabled, QComboBox:disabled {{ color: {t.missing};
    background: {t.panel}; }}
QAbstractSpinBox[flat] {{ background: transparent; border-color: transparent; padding: 0 2px; }}
QAbstractSpinBox[flat="strong"] {{ font-weight: 600; }}
QAbstractSpinBox[flat]:hover {{ border-color: {t.line}; }}
QAbstractSpinBox[flat]:focus {{ border-color: {t.accent}; background: {t.input}; }}
QAbstractSpinBox QLineEdit {{ border: none; padding: 0 6px; min-height: 0; background: transparent; }}
QAbstractSpinBox[flat] QLineEdit {{ padding: 0; }}
QAbstractSpinBox::up-button, QAbstractSpinBox::down-button {{ width: 0; height: 0; border: none; }}
QComboBox {{ padding-right: 0; }}
QComboBox::drop-down {{ border: none; width: 20px; }}
QComboBox::down-arrow {{ image: url("{icons}/chevron-{tone}.svg"); width: 10px; height: 10px; }}
QComboBox QAbstractItemView {{ background: {t.raised}; color: {t.text}; border: 1px solid {t.line};
    selection-background-color: {t.selection}; selection-color: {t.text}; outline: 0; padding: 2px; }}

QCheckBox {{ spacing: 8px; color: {t.text}; }}
QCheckBox:disabled {{ color: {t.missing}; }}
QCheckBox::indicator {{ width: 12px; height: 12px; border: 1px solid {t.dim}; border-radius: 3px;
    background: {t.input}; }}
QCheckBox::indicator:hover, QCheckBox::indicator:focus {{ border-color: {t.accent}; }}
QCheckBox::indicator:checked {{ background: {t.accent}; border-color: {t.accent}; image: url("{icons}/check.svg"); }}
QCheckBox::indicator:disabled {{ background: {t.panel}; border-color: {t.line}; }}

QMenuBar {{ background: {t.window}; color: {t.text}; padding: 0; }}
QMenuBar::item {{ background: transparent; padding: 6px 8px; border-radius: 4px; }}
QMenuBar::item:selected {{ background: {t.raised}; }}
QMenu {{ background: {t.raised}; color: {t.text}; border: 1px solid {t.line}; padding: 4px; }}
QMenu::item {{ padding: 4px 24px 4px 12px; border-radius: 3px; min-height: 16px; }}
QMenu::item:selected {{ background: {t.selection}; color: {t.text}; }}
QMenu::item:disabled {{ color: {t.missing}; }}
QMenu::separator {{ height: 1px; background: {t.line}; margin: 4px 8px; }}
QMenu::icon {{ padding-left: 8px; }}
QMenu::indicator {{ width: 12px; height: 12px; margin-left: 6px; }}
QMenu::indicator:checked {{ image: url("{icons}/tick-{tone}.svg"); }}

QScrollArea, QAbstractScrollArea {{ border: none; }}
QScrollBar:vertical {{ background: transparent; width: 8px; margin: 0; }}
QScrollBar:horizontal {{ background: transparent; height: 8px; margin: 0; }}
QScrollBar::handle {{ background: {t.line}; border-radius: 3px; margin: 1px; }}
QScrollBar::handle:vertical {{ min-height: 24px; }}
QScrollBar::handle:horizontal {{ min-width: 24px; }}
QScrollBar::handle:hover {{ background: {t.missing}; }}
QScrollBar::add-line, QScrollBar::sub-line {{ width: 0; height: 0; }}
QScrollBar::add-page, QScrollBar::sub-page {{ background: transparent; }}

QListView, QTableView, QTreeView {{ background: {t.panel}; color: {t.text}; alternate-background-color: {t.alternate};
    border: none; outline: 0; selection-background-color: {t.selection}; selection-color: {t.text}; font-size: 11px; }}
QHeaderView {{ background: {t.panel}; border: none; }}
QHeaderView::section {{ background: {t.panel}; color: {t.dim}; border: none; border-bottom: 1px solid {t.line};
    padding: 0 8px; font-size: 11px; font-weight: 400; }}
QTableCornerButton::section {{ background: {t.panel}; border: none; }}
QProgressBar {{ background: {t.line}; border: none; border-radius: 2px; min-height: 4px; max-height: 4px; }}
QProgressBar::chunk {{ background: {t.accent}; border-radius: 2px; }}
QSlider::groove:horizontal {{ height: 2px; background: {t.line}; border-radius: 1px; }}
QSlider::sub-page:horizontal {{ background: {t.accent}; }}
QSlider::handle:horizontal {{ width: 12px; height: 12px; margin: -5px 0; border-radius: 6px; background: {t.text}; }}
QTabBar::tab {{ background: {t.segment_off}; color: {t.dim}; padding: 4px 12px; border: none; }}
QTabBar::tab:selected {{ background: {t.panel}; color: {t.text}; }}
QDialog, QMessageBox {{ background: {t.panel}; }}
QLabel {{ background: transparent; }}
"""
