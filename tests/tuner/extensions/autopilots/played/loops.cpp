// Plays PX4's control libraries: the same parameters and frames.
#include <elsewhere/topic.h>

#include "loops.hpp"

struct Vehicle {
	const double period = 1.0 / bench::parameter("IMU_GYRO_RATEMAX"), curve = bench::parameter("THR_MDL_FAC");
	Loop loops[3];

	Vehicle()
	{
		printf("printed while it starts\n");
		const char *const axes[] = {"ROLL", "PITCH", "YAW"};

		for (int k = 0; k < 3; k++) {
			const std::string name = std::string("MC_") + axes[k];
			loops[k] = {bench::parameter(name + "_P"), bench::parameter(name + "RATE_P"), bench::parameter(name + "RATE_I")};
		}

		bench::unread.clear();
	}

	double share(double command) const { return curve * command * command + (1.0 - curve) * command; }

	void arm(const bench::Frame &frame)
	{
		for (int k = 0; k < 3; k++) {
			loops[k].integral = 0.0;

			for (int i = 0; i < 4; i++) {
				loops[k].integral += (k < 2 ? 0.5 * M_SQRT1_2 : 0.25) * MIX[i][k] * share(frame.held[i]);
			}
		}
	}

	bench::Motors step(const bench::Frame &frame)
	{
		double torque[3];

		for (int k = 0; k < 3; k++) {
			torque[k] = loops[k].step(frame.goal[k], frame.angles[k], frame.rate[k], period);
		}

		bench::Motors motors;

		for (int i = 0; i < 4; i++) {
			const double thrust = share(frame.throttle) + M_SQRT1_2 * (MIX[i][0] * torque[0] + MIX[i][1] * torque[1]) + MIX[i][2] * torque[2];
			motors.command[i] = sqrt(thrust);
		}

		return motors;
	}
};

int main()
{
	return bench::run<Vehicle>();
}
