"""An anemometer."""
