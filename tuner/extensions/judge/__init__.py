"""A second opinion on gains before arming, and parameters read back."""
