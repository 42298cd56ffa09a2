// How a firmware's control libraries speak with the bench: parameters by name as lines of text up to an empty one, answered by a
// line with what is refused (empty where nothing is); then frames of doubles, each answered by four motor commands.
#pragma once
#include <cfloat>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <unistd.h>

namespace bench
{

typedef double Triple[3];

// Angles [rad], rates [rad/s] in axes x forward, y right, z down; throttle: motor command (0 to 1) at which one rotor gives the
// lift that is asked for; held: where `arms` is not 0, motor commands that hold the vehicle.
struct Frame {
    Triple rate, angles, goal;
    double yaw_rate, throttle, arms, held[4];
};

struct Motors {
    double command[4];
};

inline std::map<std::string, double> parameters;
inline std::set<std::string> unread;

inline double parameter(const std::string &name)
{
    if (parameters.count(name) == 0) throw std::runtime_error("the firmware reads " + name + ", which has no value");
    unread.erase(name);
    return parameters[name];
}

inline void read_parameters()
{
    for (std::string line; std::getline(std::cin, line) && !line.empty();) {
        const auto blank = line.find(' ');
        const std::string name = line.substr(0, blank);
        parameters[name] = std::strtod(line.c_str() + blank, nullptr);
        unread.insert(name);
    }
}

// Fly a vehicle, made from the parameters, by its functions `arm` and `step` of a frame.
template <typename Vehicle> int run()
{
    // What libraries print must not reach the answers.
    const int answers = dup(1);
    dup2(2, 1);
    const auto answer = [answers](const void *content, size_t size) { return write(answers, content, size) == (ssize_t)size; };
    std::ios::sync_with_stdio(false);
    read_parameters();
    std::string refused;
    Vehicle *vehicle = nullptr;
    try {
        // Firmware counts on memory that begins as zeros.
        static Vehicle made;
        vehicle = &made;
        for (const auto &name : unread) refused += (refused.empty() ? "nothing here reads " : ", ") + name;
    } catch (const std::exception &error) {
        refused = error.what();
    }
    const std::string line = refused + "\n";
    if (!answer(line.data(), line.size()) || !refused.empty()) return 1;
    for (Frame frame; std::cin.read(reinterpret_cast<char *>(&frame), sizeof(frame));) {
        Motors motors{};
        if (frame.arms != 0.0) vehicle->arm(frame);
        else motors = vehicle->step(frame);
        if (!answer(&motors, sizeof(motors))) return 1;
    }
    return 0;
}

} // namespace bench
