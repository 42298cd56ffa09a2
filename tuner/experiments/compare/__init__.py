"""Results folders and gains files laid side by side: flown through the same scenarios and compared in pairs."""
