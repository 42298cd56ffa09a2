// ArduPilot Copter's own loops, called one after the other: gyro's filter, attitude, rates, mixing, thrust curve.
// Their order and what stands between them follow ArduCopter/Copter.cpp and AP_InertialSensor.
#include <AP_Math/AP_Math.h>
#include <AP_Motors/AP_MotorsMatrix.h>

// The attitude and the rates as they are measured.
struct AP_AHRS_View {
    Quaternion attitude;
    Vector3f gyro;
    float roll{0.f}, pitch{0.f}, yaw{0.f};

    void get_quat_body_to_ned(Quaternion &quat) const { quat = attitude; }
    Vector3f get_gyro_latest() const { return gyro; }
    float cos_roll() const { return cosf(roll); }
    float cos_pitch() const { return cosf(pitch); }
};

struct AP_Scheduler {
    float period{0.f};
    float get_filtered_loop_time() const { return period; }
};

namespace AP
{
AP_Scheduler &scheduler()
{
    static AP_Scheduler scheduler;
    return scheduler;
}
} // namespace AP

static AP_HAL::RCOutput rcout;
static AP_HAL::Util util;
static const AP_HAL::HAL outputs{&rcout, &util};
const AP_HAL::HAL &hal = outputs;

#include <AC_PID/AC_P.cpp>
#include <AC_PID/AC_PID.cpp>
#include <AP_Math/AP_Math.cpp>
#include <AP_Math/control.cpp>
#include <AP_Math/matrix3.cpp>
#include <AP_Math/quaternion.cpp>
#include <AP_Math/vector2.cpp>
#include <AP_Math/vector3.cpp>
#include <AP_Motors/AP_MotorsMatrix.cpp>
#include <AP_Motors/AP_MotorsMulticopter.cpp>
#include <AP_Motors/AP_Motors_Class.cpp>
#include <AP_Motors/AP_Motors_Thrust_Linearization.cpp>
#include <Filter/DerivativeFilter.cpp>
#include <Filter/LowPassFilter.cpp>
#include <Filter/LowPassFilter2p.cpp>
#include <Filter/SlewLimiter.cpp>

#include <AC_AttitudeControl/AC_AttitudeControl.cpp>
#include <AC_AttitudeControl/AC_AttitudeControl_Multi.cpp>
// Called by Copter 4.6.
#if __has_include(<AC_AttitudeControl/ControlMonitor.cpp>)
#include <AC_AttitudeControl/ControlMonitor.cpp>
#endif

namespace
{

// Motors at the bench's rotors: front left, front right, rear left, rear right.
const uint8_t PLACES[] = {2, 0, 1, 3};
// Longest time to spool up [s].
constexpr float PATIENCE = 30.f;

// Copter 4.7 says set_dt_s, 4.6 set_dt.
template <typename Part> auto set_period(Part &part, float period, int) -> decltype(part.set_dt_s(period))
{
    part.set_dt_s(period);
}

template <typename Part> auto set_period(Part &part, float period, long) -> decltype(part.set_dt(period))
{
    part.set_dt(period);
}

struct Motors : AP_MotorsMatrix {
    float actuator(uint8_t i) const { return _actuator[i]; }
    Vector3f factors(uint8_t i) const { return Vector3f(_roll_factor[i], _pitch_factor[i], _yaw_factor[i]); }
};

Vector3f single(const bench::Triple &values) { return Vector3f((float)values[0], (float)values[1], (float)values[2]); }

class Vehicle
{
public:
    Vehicle()
    {
        AP::scheduler().period = _period;
        AP_Param::load(&_motors, AP_MotorsMulticopter::var_info, "MOT_");
        AP_Param::load(&_control, AC_AttitudeControl_Multi::var_info, "ATC_");
        set_period(_control, _period, 0);
        set_period(_motors, _period, 0);
        _motors.init(AP_Motors::MOTOR_FRAME_QUAD, (AP_Motors::motor_frame_type)bench::parameter("FRAME_TYPE"));
        _filter.set_cutoff_frequency(1.f / _period, (float)bench::parameter("INS_GYRO_FILTER"));
        if (!_motors.initialised_ok()) throw std::runtime_error("the firmware knows no frame of this FRAME_TYPE");
    }

    // Spool up, settle the filters, and fill the integrals with what holds the vehicle.
    void arm(const bench::Frame &frame)
    {
        _motors.armed(true);
        _motors.set_interlock(true);
        _motors.set_desired_spool_state(AP_Motors::DesiredSpoolState::THROTTLE_UNLIMITED);
        for (float time = 0.f; !_motors.spool_up_complete() && time < PATIENCE; time += _period) output(0.f);
        if (!_motors.spool_up_complete()) throw std::runtime_error("the motors do not spool up");
        _filter.reset(single(frame.rate));
        sense(frame);
        _control.relax_attitude_controllers();
        AC_PID *const rates[]{&_control.get_rate_roll_pid(), &_control.get_rate_pitch_pid(), &_control.get_rate_yaw_pid()};
        for (int axis = 0; axis < 3; axis++) {
            rates[axis]->update_all(0.f, _ahrs.gyro[axis], _period);
            rates[axis]->set_integrator(held(frame, axis));
        }
    }

    bench::Motors step(const bench::Frame &frame)
    {
        sense(frame);
        Quaternion goal = attitude(frame.goal);
        // The rate of the heading turns the goal about the vertical.
        _control.input_quaternion(goal, goal.inverse() * Vector3f(0.f, 0.f, (float)frame.yaw_rate));
        _control.rate_controller_run_dt(_ahrs.gyro, _period);
        output(share(frame.throttle));
        const float low = _motors.thr_lin.get_spin_min(), high = _motors.thr_lin.get_spin_max();
        bench::Motors motors;
        for (int i = 0; i < 4; i++) motors.command[i] = (_motors.actuator(PLACES[i]) - low) / (high - low);
        return motors;
    }

private:
    float share(double command) const { return _motors.thr_lin.remove_thrust_curve_and_volt_scaling((float)command); }

    static Quaternion attitude(const bench::Triple &angles)
    {
        Quaternion made;
        made.from_euler((float)angles[0], (float)angles[1], (float)angles[2]);
        return made;
    }

    void sense(const bench::Frame &frame)
    {
        const Vector3f angles = single(frame.angles);
        _ahrs = {attitude(frame.angles), _filter.apply(single(frame.rate)), angles.x, angles.y, angles.z};
    }

    void output(float thrust)
    {
        _control.set_throttle_out(thrust, false, 0.f);
        _motors.output();
        bench::microseconds += (uint64_t)std::lround(1e6 * _period);
    }

    // The output of an axis that held motors give.
    float held(const bench::Frame &frame, int axis) const
    {
        float output = 0.f, squares = 0.f;
        for (int i = 0; i < 4; i++) {
            const float factor = _motors.factors(PLACES[i])[axis];
            output += factor * share(frame.held[i]);
            squares += factor * factor;
        }
        return output / squares;
    }

    const float _period = (float)(1.0 / bench::parameter("SCHED_LOOP_RATE"));
    LowPassFilter2pVector3f _filter;
    AP_AHRS_View _ahrs;
    AP_MultiCopter _limits;
    Motors _motors;
    AC_AttitudeControl_Multi _control{_ahrs, _limits, _motors};
};

} // namespace

int main() { return bench::run<Vehicle>(); }
