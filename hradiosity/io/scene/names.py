"""References between tables of a scene file: materials and luminaires by name."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from hradiosity.io.scene.lines import Location
from hradiosity.io.scene.report import Report, did_you_mean
from hradiosity.io.scene.schema_light import ReflectanceColour
from hradiosity.model.geometry import NONE


@dataclass(frozen=True)
class Names:
    """Names of all materials and luminaires, those of faulty tables too: one mistake shall not make ten faults.

    guessed : materials that have no table but the colour of a texture; they follow the others
    """

    materials: Sequence[str]
    luminaires: Sequence[str]
    guessed: dict[str, ReflectanceColour] = field(default_factory=dict)

    def guess(self, name: str, colour: ReflectanceColour) -> int:
        """Number of a material that is guessed from a colour; another name if this one has another colour."""
        while name in self.materials or self.guessed.get(name, colour) != colour:
            name += "'"
        self.guessed[name] = colour
        return len(self.materials) + list(self.guessed).index(name)

    def material_index(self, name: str | None) -> int:
        """Number of a material; 0 for an unknown one, which ``check_material`` reports."""
        return self.materials.index(name) if name in self.materials else 0

    def luminaire_index(self, name: str | None) -> int:
        """Number of a luminaire; NONE for none."""
        return self.luminaires.index(name) if name in self.luminaires else NONE

    def check_material(self, name: str | None, location: Location, report: Report) -> None:
        """Report a material that does not exist."""
        if name is not None and name not in self.materials:
            report.fault(location, f"no material {name!r}", did_you_mean(name, self.materials))

    def check_luminaire(self, name: str | None, location: Location, report: Report) -> None:
        """Report a luminaire that does not exist."""
        if name is not None and name not in self.luminaires:
            report.fault(location, f"no luminaire {name!r}", did_you_mean(name, self.luminaires))
