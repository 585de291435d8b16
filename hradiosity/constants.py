"""Physical constants, each with its unit and source."""

from typing import Final

MAXIMUM_LUMINOUS_EFFICACY: Final = 683.002
"""K_m, lm W⁻¹: maximum luminous efficacy of radiation for photopic vision. CIE 018:2019."""

PLANCK_C2: Final = 1.438776877e-2
"""Second radiation constant hc/k, m K. CODATA 2018, exact."""

PLANCK_C1L: Final = 1.191042972397188e-16
"""First radiation constant for spectral radiance 2hc², W m² sr⁻¹. CODATA 2018, exact."""
