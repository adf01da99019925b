"""Where the virtual camera stands before a mesh, as options of the command line. Loads neither numpy nor Qt."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from engine.files.complaint import bad_field

if TYPE_CHECKING:
    from pathlib import Path

    from engine.files.scan_file import ScanFile
    from engine.mesh import TriangleMesh
    from engine.scan.mesh_view import MeshView


class ViewOptions(BaseModel):
    """The camera before a mesh; what is left out is placed automatically."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    turn: float | None = Field(default=None, ge=-360, le=360, description="Turn of a mesh to the right, degrees.")
    tilt: float | None = Field(default=None, ge=-360, le=360, description="Tilt of a mesh downwards, degrees.")
    roll: float | None = Field(default=None, ge=-360, le=360, description="Roll of a mesh to its left, degrees.")
    look_at: tuple[float, float, float] | None = Field(
        default=None, description="Point of a mesh in the middle of the picture, mm."
    )
    distance_mm: float | None = Field(default=None, ge=10, le=100_000, description="From there to the camera, mm.")
    fov: float | None = Field(default=None, ge=1, le=120, description="Field of view of the height, degrees.")
    width: int | None = Field(default=None, ge=16, le=4000, description="Width of the picture of a mesh, pixels.")
    height: int | None = Field(default=None, ge=16, le=4000, description="Height of the picture of a mesh, pixels.")

    @classmethod
    def checked(cls, **values: object) -> ViewOptions:
        """Return options of ``values``; InputError names the first that is out of its limits."""
        try:
            return cls.model_validate(values)
        except ValidationError as error:
            raise bad_field(error, "view") from None

    @classmethod
    def of(cls, view: MeshView) -> ViewOptions:
        """Return the options that give exactly ``view``."""
        turn, tilt, roll = view.angles_deg
        return cls(
            turn=turn, tilt=tilt, roll=roll, look_at=view.look_at_mm, distance_mm=view.distance_mm,
            fov=view.field_of_view_deg, width=view.width, height=view.height,
        )  # fmt: skip

    @property
    def given(self) -> bool:
        """Whether any of them was chosen."""
        return any(value is not None for value in self.model_dump().values())

    def view(self, mesh: TriangleMesh) -> MeshView:
        """Return the view of a mesh: placed automatically but for what was chosen."""
        return self.placed(mesh)[0]

    def placed(self, mesh: TriangleMesh) -> tuple[MeshView, tuple[str, ...]]:
        """Return the view of a mesh and, where anything of it was placed automatically, how and how surely.

        Raises
        ------
        InputError
            On values that no camera has.
        """
        from dataclasses import replace

        from engine.files.mesh_scan import in_words
        from engine.scan.mesh_view import HEIGHT, WIDTH, MeshView, propose_view

        size = self.width or WIDTH, self.height or HEIGHT
        told: tuple[str, ...] = ()
        if None not in (self.turn, self.tilt, self.roll, self.look_at, self.distance_mm, self.fov):
            view = MeshView(width=size[0], height=size[1])
        else:
            proposed = propose_view(mesh, *size)
            asked = ", ".join(name.replace("_", " ") for name in self.model_dump(exclude_none=True))
            view, told = proposed.view, (f"{in_words(proposed)}; {asked} as asked",)
        if (self.turn, self.tilt, self.roll) != (None, None, None):
            angles = zip((self.turn, self.tilt, self.roll), view.angles_deg, strict=True)
            view = view.turned(*(own if given is None else given for given, own in angles))
        view = replace(
            view,
            look_at_mm=self.look_at or view.look_at_mm,
            distance_mm=self.distance_mm or view.distance_mm,
            field_of_view_deg=self.fov or view.field_of_view_deg,
        )
        return view, told

    def words(self) -> list[str]:
        """Return the options as words of a command line."""
        words: list[str] = []
        for name, value in self.model_dump(exclude_none=True).items():
            numbers = value if isinstance(value, tuple) else (value,)
            words += [f"--{name.replace('_', '-')}", *(repr(number) for number in numbers)]
        return words


def read_placed(path: Path, unit: str | None, options: ViewOptions) -> ScanFile:
    """Read a scan of any kind; options of the view need a mesh. ``warnings`` say what was placed automatically.

    Raises
    ------
    InputError
        As the readers do, and for options of the view with a range image.
    """
    from dataclasses import replace

    from engine.errors import InputError
    from engine.files.mesh_file import read_mesh
    from engine.files.mesh_scan import is_mesh, scan_of
    from engine.files.scan import read_scan
    from engine.files.source import checked_file

    if not options.given:
        return read_scan(path, unit)
    if not is_mesh(checked_file(path)):
        raise InputError(str(path), "is a range image: it has been seen by its own camera", "leave the view out")
    file = read_mesh(path, unit)
    view, told = options.placed(file.mesh)
    seen = scan_of(file, view)
    return replace(seen, warnings=(*seen.warnings, *told))
