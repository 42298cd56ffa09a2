// PX4's rate and attitude control of one axis as functions in C, compiled from its sources as they stand.
#include <rate_control/rate_control.cpp>

#include <AttitudeControl.cpp>
#include <mathlib/math/filter/AlphaFilter.hpp>
#include <mathlib/math/filter/LowPassFilter2p.hpp>
#include <mathlib/math/filter/NotchFilter.hpp>

// A double, also where every float of the sources is one.
using Number = decltype(bench::Frame::throttle);

extern "C" int px4_scalar_bytes() { return sizeof(float); }

// gains: p, i, d, ff, i_limit, gyro_cutoff, d_cutoff, notch, notch_width. The filters are settled at rates[0] and step with the
// loop; saturated is the sign in which the allocation saturates.
extern "C" void px4_rate_loop(Number rate_hz, const Number *gains, int n, const Number *rates, const Number *setpoints,
                              const int *saturated, Number *torque)
{
    const float sampling = (float)rate_hz;
    const auto along = [gains](int i) { return Vector3f((float)gains[i], 0.f, 0.f); };
    RateControl control;
    control.setPidGains(along(0), along(1), along(2));
    control.setFeedForwardGain(along(3));
    control.setIntegratorLimit(along(4));
    math::LowPassFilter2p<float> low_pass;
    low_pass.set_cutoff_frequency(sampling, (float)gains[5]);
    low_pass.reset((float)rates[0]);
    AlphaFilter<float> derivative;
    if (!derivative.setCutoffFreq(sampling, (float)gains[6])) derivative.setAlpha(1.f);
    math::NotchFilter<float> notch;
    notch.setParameters(sampling, (float)gains[7], (float)gains[8]);
    float before = (float)rates[0];
    for (int k = 0; k < n; k++) {
        float rate[1]{(float)rates[k]};
        if (notch.getNotchFreq() > 0.f) notch.applyArray(rate, 1);
        low_pass.applyArray(rate, 1);
        const Vector3f slope(derivative.update((rate[0] - before) * sampling), 0.f, 0.f);
        before = rate[0];
        control.setPositiveSaturationFlag(0, saturated[k] > 0);
        control.setNegativeSaturationFlag(0, saturated[k] < 0);
        torque[k] = control.update(Vector3f(rate[0], 0.f, 0.f), Vector3f((float)setpoints[k], 0.f, 0.f), slope,
                                   1.f / sampling, false)(0);
    }
}

// The rate asked for about an axis; the attitude turns about it alone, the weight of yaw is 1.
extern "C" Number px4_attitude(int axis, Number gain, Number angle, Number setpoint, Number yaw_rate)
{
    const auto turned = [axis](float value) {
        Vector3f angles;
        angles(axis) = value;
        return Quatf(Eulerf(angles(0), angles(1), angles(2)));
    };
    AttitudeControl control;
    control.setProportionalGain(Vector3f(1.f, 1.f, 1.f) * (float)gain, 1.f);
    control.setRateLimit(Vector3f(1.f, 1.f, 1.f) * 1000.f);
    control.setAttitudeSetpoint(turned((float)setpoint), (float)yaw_rate);
    return control.update(turned((float)angle))(axis);
}
