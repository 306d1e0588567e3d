"""Vision: Aff(2) particle filters, reconstruction and prediction of one target."""
