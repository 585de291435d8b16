"""Form factors, one method a file."""
