// What ArduPilot's control libraries ask of its other parts, for a build without them: parameters are the libraries' own defaults
// and those of the bench, outputs lead nowhere, time is counted by the bench.
#pragma once
#include "protocol.hpp"

#include <cstdarg>
#include <cstddef>
#include <inttypes.h>

#define HAL_LOGGING_ENABLED 0
#define AP_SCRIPTING_ENABLED 0
#define AP_FILTER_ENABLED 0
#define AP_BATTERY_ENABLED 0
#define AP_CUSTOMROTATIONS_ENABLED 0
#define AP_MOTORS_DENSITY_COMP 0
#define NUM_SERVO_CHANNELS 16
#define APM_BUILD_ArduCopter 1
#define APM_BUILD_ArduPlane 2
#define APM_BUILD_Heli 3
#define APM_BUILD_UNKNOWN 4
#define APM_BUILD_TYPE(kind) ((kind) == APM_BUILD_ArduCopter)
#define APM_BUILD_COPTER_OR_HELI 1
#define __AP_LINE__ 0
#define INTERNAL_ERROR(...)
#define AP_PARAMDEFV(...)
#define FUNCTOR_TYPEDEF(name, result, ...) typedef result (*name)(__VA_ARGS__)

enum MAV_TYPE {
    MAV_TYPE_GENERIC, MAV_TYPE_QUADROTOR, MAV_TYPE_HEXAROTOR, MAV_TYPE_OCTOROTOR, MAV_TYPE_DECAROTOR, MAV_TYPE_DODECAROTOR,
    MAV_TYPE_TRICOPTER, MAV_TYPE_COAXIAL
};

namespace bench
{
inline uint64_t microseconds = 1000000;
}

namespace AP_HAL
{
inline uint32_t millis() { return (uint32_t)(bench::microseconds / 1000); }
inline uint32_t micros() { return (uint32_t)bench::microseconds; }
inline uint64_t micros64() { return bench::microseconds; }
template <typename... T> void panic(T...) { abort(); }

struct RCOutput {
    enum Mode {
        MODE_PWM_NORMAL, MODE_PWM_ONESHOT, MODE_PWM_ONESHOT125, MODE_PWM_BRUSHED, MODE_PWM_DSHOT150, MODE_PWM_DSHOT300,
        MODE_PWM_DSHOT600, MODE_PWM_DSHOT1200
    };
    template <typename... T> void set_freq(T...) {}
    template <typename... T> void set_dshot_esc_type(T...) {}
    template <typename... T> void set_output_mode(T...) {}
    template <typename... T> void set_esc_scaling(T...) {}
};

struct Util {
    template <typename... T> int snprintf(T...) { return 0; }
};

struct HAL {
    RCOutput *rcout;
    Util *util;
};
} // namespace AP_HAL

struct SRV_Channel {
    enum Function { k_none, k_boost_throttle, k_roll_out, k_pitch_out, k_yaw_out, k_thrust_out, k_throttleLeft, k_throttleRight };
    // Its name in Copter 4.6.
    typedef Function Aux_servo_function_t;
};

struct SRV_Channels {
    template <typename... T> static void set_output_scaled(T...) {}
    template <typename... T> static void set_output_pwm(T...) {}
    template <typename... T> static void set_range(T...) {}
    template <typename... T> static void set_angle(T...) {}
    template <typename... T> static void set_aux_channel_default(T...) {}
    static SRV_Channel::Function get_motor_function(uint8_t) { return SRV_Channel::k_none; }
    static uint32_t get_output_channel_mask(SRV_Channel::Function) { return 0; }
    static int get_dshot_esc_type() { return 0; }
    static bool have_digital_outputs(uint32_t) { return false; }
    static bool find_channel(SRV_Channel::Function, uint8_t &) { return true; }
};

struct AP_Notify {
    struct Flags {
        bool armed;
    };
    static inline Flags flags{};
};

struct AP_BoardConfig {
    template <typename... T> static void config_error(T...) { abort(); }
};

class AC_PosControl;

template <typename T> struct AP_ParamT {
    typedef T type;
    const T &get() const { return value; }
    operator const T &() const { return value; }
    void set(const T &given) { value = given; }
    void set_default(const T &given) { value = given; }
    void set_and_default(const T &given) { value = given; }
    void set_and_save(const T &given) { value = given; }
    void load() {}
    void save() {}
    bool configured() const { return true; }
    T value{};
};

typedef AP_ParamT<float> AP_Float;
typedef AP_ParamT<int8_t> AP_Int8;
typedef AP_ParamT<int16_t> AP_Int16;
typedef AP_ParamT<int32_t> AP_Int32;

template <typename T> struct AP_Enum : AP_Int8 {
    operator const T() const { return (T)value; }
};

// The tables of parameters that the libraries have.
struct AP_Param {
    struct GroupInfo {
        const char *name;
        ptrdiff_t offset;
        void (*set)(void *, float);
        float usual;
        // Where in the object its default lies, below 0 for one in the table.
        ptrdiff_t usual_offset;
        const GroupInfo *group;
    };

    template <typename P> static void set_number(void *place, float number)
    {
        static_cast<P *>(place)->value = (typename P::type)number;
    }

    static void setup_object_defaults(const void *object, const GroupInfo *info)
    {
        for (char *const begin = (char *)object; info->name != nullptr; info++) {
            if (info->group != nullptr) continue;
            info->set(begin + info->offset, info->usual_offset < 0 ? info->usual : *(const float *)(begin + info->usual_offset));
        }
    }

    // Give an object the bench's parameters whose names begin with a prefix.
    static void load(void *object, const GroupInfo *info, const std::string &prefix)
    {
        for (; info->name != nullptr; info++) {
            const std::string name = prefix + info->name;
            char *const place = (char *)object + info->offset;
            if (info->group != nullptr) load(place, info->group, name);
            else if (bench::parameters.count(name) != 0) info->set(place, (float)bench::parameter(name));
        }
    }
};

#define AP_SETTER(clazz, element) &AP_Param::set_number<std::remove_reference_t<decltype(((clazz *)nullptr)->element)>>
#define AP_GROUPINFO(name, index, clazz, element, usual) \
    {name, offsetof(clazz, element), AP_SETTER(clazz, element), (float)(usual), -1, nullptr}
#define AP_GROUPINFO_FLAGS(name, index, clazz, element, usual, flags) AP_GROUPINFO(name, index, clazz, element, usual)
#define AP_GROUPINFO_FRAME(name, index, clazz, element, usual, frame) AP_GROUPINFO(name, index, clazz, element, usual)
#define AP_GROUPINFO_FLAGS_DEFAULT_POINTER(name, index, clazz, element, usual) \
    {name, offsetof(clazz, element), AP_SETTER(clazz, element), 0.f, (ptrdiff_t)offsetof(clazz, usual), nullptr}
#define AP_SUBGROUPINFO(element, name, index, clazz, kind) {name, offsetof(clazz, element), nullptr, 0.f, -1, kind::var_info}
#define AP_NESTEDGROUPINFO(clazz, index) {"", 0, nullptr, 0.f, -1, clazz::var_info}
#define AP_GROUPEND {nullptr, 0, nullptr, 0.f, -1, nullptr}
