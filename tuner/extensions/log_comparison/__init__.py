"""Two flight logs side by side: ratios with intervals, and the prediction of the second."""
