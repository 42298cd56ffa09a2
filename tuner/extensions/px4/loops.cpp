// PX4's own loops, called one after the other: attitude, gyro and D filters, rates, allocation, thrust curve.
// Their order and what stands between them follow mc_att_control, mc_rate_control, sensors/vehicle_angular_velocity,
// control_allocator and mixer_module of PX4-Autopilot.
// It brings the mathematics that the next ones count on.
#include <rate_control/rate_control.cpp>

#include <ActuatorEffectiveness.cpp>
#include <ActuatorEffectivenessRotors.cpp>
#include <AttitudeControl.cpp>
#include <ControlAllocation.cpp>
#include <ControlAllocationPseudoInverse.cpp>
#include <ControlAllocationSequentialDesaturation.cpp>
#include <mathlib/math/filter/AlphaFilter.hpp>
#include <mathlib/math/filter/LowPassFilter2p.hpp>
#include <mathlib/math/filter/NotchFilter.hpp>
#include <mixer_module/functions/FunctionMotors.hpp>

namespace
{

// The allocator reports saturation no more often than this [us].
constexpr uint64_t STATUS_INTERVAL = 5000;

float number(const std::string &name) { return (float)bench::parameter(name); }

Vector3f single(const bench::Triple &values) { return Vector3f((float)values[0], (float)values[1], (float)values[2]); }

Vector3f per_axis(const std::string &ending)
{
    return Vector3f(number("MC_ROLL" + ending), number("MC_PITCH" + ending), number("MC_YAW" + ending));
}

// The filters of one axis of the gyro.
struct Gyro {
    math::NotchFilter<float> notch[2];
    math::LowPassFilter2p<float> low_pass;
    AlphaFilter<float> acceleration;
    float rate{0.f}, slope{0.f};

    explicit Gyro(float sampling)
    {
        for (int i = 0; i < 2; i++) {
            const std::string name = "IMU_GYRO_NF" + std::to_string(i);
            notch[i].setParameters(sampling, number(name + "_FRQ"), number(name + "_BW"));
        }
        low_pass.set_cutoff_frequency(sampling, number("IMU_GYRO_CUTOFF"));
        if (!acceleration.setCutoffFreq(sampling, number("IMU_DGYRO_CUTOFF"))) acceleration.setAlpha(1.f);
    }

    void settle(float measured)
    {
        for (auto &each : notch) each.reset(measured);
        low_pass.reset(measured);
        acceleration.reset(0.f);
        rate = measured;
    }

    void take(float measured, float sampling)
    {
        float data[1]{measured};
        for (auto &each : notch) {
            if (each.getNotchFreq() > 0.f) each.applyArray(data, 1);
        }
        low_pass.applyArray(data, 1);
        slope = acceleration.update((data[0] - rate) * sampling);
        rate = data[0];
    }
};

class Vehicle
{
public:
    Vehicle()
    {
        _attitude.setProportionalGain(per_axis("_P"), number("MC_YAW_WEIGHT"));
        _attitude.setRateLimit(per_axis("RATE_MAX") * math::radians(1.f));
        set_gains();
        _rate.setIntegratorLimit(Vector3f(number("MC_RR_INT_LIM"), number("MC_PR_INT_LIM"), number("MC_YR_INT_LIM")));
        _rate.setFeedForwardGain(per_axis("RATE_FF"));
        _yaw.setCutoffFreq(number("MC_YAW_TQ_CUTOFF"));
        ActuatorEffectiveness::Configuration made{};
        _rotors.getEffectivenessMatrix(made, EffectivenessUpdateReason::CONFIGURATION_UPDATE);
        _allocation.setNormalizeRPY(true);
        _allocation.setEffectivenessMatrix(
            made.effectiveness_matrices[0], made.trim[0], made.linearization_point[0], made.num_actuators_matrix[0], true);
        _allocation.allocate();
    }

    // Settle the filters, and fill the integrals with what holds the vehicle: by their own update, in one long step of small errors.
    void arm(const bench::Frame &frame)
    {
        ActuatorEffectiveness::ActuatorVector held;
        for (int i = 0; i < 3; i++) _gyro[i].settle((float)frame.rate[i]);
        for (int i = 0; i < 4; i++) held(i) = share((float)frame.held[i]);
        _allocation.setActuatorSetpoint(held);
        const auto control = _allocation.getAllocatedControl();
        const Vector3f torque(control(0), control(1), control(2));
        const float longest = 1e4f;
        _rate.resetIntegral();
        _rate.setSaturationStatus({}, {});
        _rate.setPidGains(Vector3f(), Vector3f(1.f, 1.f, 1.f), Vector3f());
        _rate.update(Vector3f(), torque / longest, Vector3f(), longest, false);
        set_gains();
        _yaw.reset(torque(2));
        _now = _last_status = 0;
    }

    bench::Motors step(const bench::Frame &frame)
    {
        const Vector3f seen = single(frame.angles), goal = single(frame.goal);
        _attitude.setAttitudeSetpoint(Quatf(Eulerf(goal(0), goal(1), goal(2))), (float)frame.yaw_rate);
        const Vector3f wanted = _attitude.update(Quatf(Eulerf(seen(0), seen(1), seen(2))));
        Vector3f rate, acceleration;
        for (int i = 0; i < 3; i++) {
            _gyro[i].take((float)frame.rate[i], _sampling);
            rate(i) = _gyro[i].rate;
            acceleration(i) = _gyro[i].slope;
        }
        const float period = 1.f / _sampling;
        Vector3f torque = _rate.update(rate, wanted, acceleration, period, false);
        torque(2) = _yaw.update(torque(2), period);
        return mix(torque, share((float)frame.throttle));
    }

private:
    // What a motor command (0 to 1) is as a share of the thrust.
    float share(float command) const { return _curve * command * command + (1.f - _curve) * command; }

    void set_gains()
    {
        const Vector3f k = per_axis("RATE_K");
        _rate.setPidGains(k.emult(per_axis("RATE_P")), k.emult(per_axis("RATE_I")), k.emult(per_axis("RATE_D")));
    }

    bench::Motors mix(const Vector3f &torque, float thrust)
    {
        const float control[]{torque(0), torque(1), torque(2), 0.f, 0.f, -thrust};
        _allocation.setControlSetpoint(matrix::Vector<float, ControlAllocation::NUM_AXES>(control));
        _allocation.allocate();
        _allocation.clipActuatorSetpoint();
        report();
        const auto &shares = _allocation.getActuatorSetpoint();
        float values[4]{shares(0), shares(1), shares(2), shares(3)};
        FunctionMotors::updateValues(0, _curve, values, 4);
        bench::Motors motors;
        for (int i = 0; i < 4; i++) motors.command[i] = 0.5 * (1.0 + values[i]);
        return motors;
    }

    // What the allocation could not give, as control_allocator_status tells it to the rate loops.
    void report()
    {
        _now += (uint64_t)std::lround(1e6 / _sampling);
        if (_now - _last_status < STATUS_INTERVAL) return;
        _last_status = _now;
        const matrix::Vector<float, ControlAllocation::NUM_AXES> lost =
            _allocation.getControlSetpoint() - _allocation.getAllocatedControl();
        const bool achieved = Vector3f(lost(0), lost(1), lost(2)).norm_squared() < 1e-6f;
        Vector3<bool> above, below;
        for (int i = 0; i < 3; i++) {
            above(i) = !achieved && lost(i) > FLT_EPSILON;
            below(i) = !achieved && lost(i) < -FLT_EPSILON;
        }
        _rate.setSaturationStatus(above, below);
    }

    const float _sampling = number("IMU_GYRO_RATEMAX"), _curve = number("THR_MDL_FAC");
    Gyro _gyro[3]{Gyro(_sampling), Gyro(_sampling), Gyro(_sampling)};
    AttitudeControl _attitude;
    RateControl _rate;
    AlphaFilter<float> _yaw;
    ActuatorEffectivenessRotors _rotors{nullptr};
    ControlAllocationSequentialDesaturation _allocation;
    uint64_t _now{0}, _last_status{0};
};

} // namespace

int main() { return bench::run<Vehicle>(); }
