"""What hangs on each open place of chapter 5, one at a time."""
