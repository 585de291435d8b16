"""What the user wrote: geometry, materials, luminaires, sensors; host only, SI units, immutable."""
