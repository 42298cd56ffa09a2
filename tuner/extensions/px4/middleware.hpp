// What PX4's control libraries ask of its middleware, for a build without it: parameters are those of the bench, topics are empty.
#pragma once
#include "protocol.hpp"

#define PX4_ISFINITE(x) std::isfinite(x)
#define PX4_ERR(...)
#define PX4_WARN(...)
#define M_PI_F 3.14159265358979324f
#define M_TWOPI_F 6.28318530717958648f
#define M_PI_2_F 1.57079632679489662f
#define M_PI_PRECISE 3.141592653589793238462643383279502884
#define M_DEG_TO_RAD_F 0.0174532925199432958f
#define M_RAD_TO_DEG_F 57.2957795130823209f
#define ORB_ID(topic) 0
#define IN_PARENTHESES(...) __VA_ARGS__
#define DEFINE_PARAMETERS(parameter) IN_PARENTHESES parameter;

using hrt_abstime = uint64_t;
using param_t = const char *;

namespace time_literals
{
}

namespace px4
{
struct WorkItem {
};
namespace params
{
struct MC_AIRMODE {
    static constexpr param_t name = "MC_AIRMODE";
};
struct CA_ROTOR_COUNT {
    static constexpr param_t name = "CA_ROTOR_COUNT";
};
} // namespace params
} // namespace px4

inline param_t param_find(const char *name)
{
    static std::set<std::string> names;
    return names.insert(name).first->c_str();
}

template <typename T> void param_get(param_t name, T *value) { *value = (T)bench::parameter(name); }

template <typename Name> struct ParamInt {
    int32_t value = (int32_t)bench::parameter(Name::name);
    int32_t get() const { return value; }
};

struct ModuleParams {
    ModuleParams(ModuleParams *) {}
    virtual ~ModuleParams() = default;
    virtual void updateParams() {}
};

namespace uORB
{
struct SubscriptionCallbackWorkItem {
    SubscriptionCallbackWorkItem(px4::WorkItem *, int) {}
    template <typename T> bool update(T *) { return false; }
};
} // namespace uORB

struct rate_ctrl_status_s {
    float rollspeed_integ, pitchspeed_integ, yawspeed_integ;
};

struct control_allocator_status_s {
    float unallocated_torque[3], unallocated_thrust[3];
};

struct actuator_motors_s {
    static constexpr int NUM_CONTROLS = 12, ACTUATOR_FUNCTION_MOTOR1 = 101;
    hrt_abstime timestamp_sample;
    uint16_t reversible_flags;
    float control[NUM_CONTROLS];
};

enum class OutputFunction : int32_t {
    Motor1 = actuator_motors_s::ACTUATOR_FUNCTION_MOTOR1,
    MotorMax = Motor1 + actuator_motors_s::NUM_CONTROLS - 1
};
