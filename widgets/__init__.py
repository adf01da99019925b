"""What is seen and touched: takes engine values, says what the user wants, changes nothing by itself."""

from __future__ import annotations

from widgets.constants_guard import protect

protect()
