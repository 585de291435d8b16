"""What is where: ray structure, elements, findings about the geometry."""
