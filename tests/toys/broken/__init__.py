"""An analysis that fails."""
