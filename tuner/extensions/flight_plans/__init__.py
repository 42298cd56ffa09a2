"""An experiment to fly: excitations of one axis after the other, long and strong enough for the intervals that are asked for."""
