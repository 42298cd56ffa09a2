"""An airframe estimated from its parts list, with 95 % ranges."""
