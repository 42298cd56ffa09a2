// Plays a checkout: our reading of PX4's loops without filters, D and limits of the integral, on a square X.
#pragma once

struct Loop {
	double outer, p, i, integral{0.0};

	double step(double goal, double angle, double rate, double h)
	{
		const double error = outer * (goal - angle) - rate, output = p * error + integral;
		const double share = error / 6.981317007977318;
		integral += h * i * error * fmax(0.0, 1.0 - share * share);
		return output;
	}
};

// Signs of roll, pitch and yaw of our rotors: front left, front right, rear left, rear right.
const double MIX[4][3] = {{1.0, 1.0, -1.0}, {-1.0, 1.0, 1.0}, {1.0, -1.0, 1.0}, {-1.0, -1.0, -1.0}};
