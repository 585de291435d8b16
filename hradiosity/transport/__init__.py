"""Light transport without wavelengths: direct light, exchange between elements."""
