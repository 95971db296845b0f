// Questions of `benches/against/peer.rs` to each peer, line by line on standard input, and the answers.
//
//   rig N, then N lines of a body    -> ready
//   motion, then its numbers         -> set
//   found KERNEL                     -> COUNT, then COUNT numbers
//   time KERNEL CALLS                -> nanoseconds of one call
//
// Kernels: 0 inverse dynamics, 1 forward dynamics, 2 mass matrix, 3 forward kinematics with velocities. Quaternions are
// x y z w. A root's motion is in body axes, its accelerations classical; a ball's are in body axes.
#pragma once

#include <chrono>
#include <cstdio>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

enum Kernel { RNEA, ABA, CRBA, FK };
enum JointKind { FREE, BALL, REVOLUTE };

struct Body {
    int parent, joint;
    double axis[3], at[3], quat[4], mass, center[3];
    // Inertia about the centre of mass: xx xy xz yy yz zz.
    double inertia[6];
};

// A ball joint uses quat, omega, alpha; a revolute joint uses turn: angle, speed and acceleration.
struct Joint {
    double quat[4], omega[3], alpha[3], turn[3];
};

struct Motion {
    double quat[4], at[3], angular[3], linear[3], angular_acceleration[3], linear_acceleration[3];
    std::vector<Joint> joints;
};

class Peer {
public:
    virtual ~Peer() = default;
    virtual void set(const Motion& motion) = 0;
    virtual void run(int kernel) = 0;
    // RNEA: moment and force on the root in body axes, then moments of ball joints and torques. ABA: accelerations in
    // this order. CRBA: the kinetic energy, computed with the mass matrix. FK: world position of the last body.
    virtual std::vector<double> found(int kernel) = 0;
};

template <std::size_t N> void read(double (&numbers)[N]) {
    for (double& number : numbers) std::cin >> number;
}

inline std::vector<Body> read_rig() {
    int count = 0;
    std::cin >> count;
    std::vector<Body> bodies(count);
    for (Body& body : bodies) {
        std::cin >> body.parent >> body.joint;
        read(body.axis);
        read(body.at);
        read(body.quat);
        std::cin >> body.mass;
        read(body.center);
        read(body.inertia);
    }
    return bodies;
}

inline Motion read_motion(std::size_t joints) {
    Motion motion;
    read(motion.quat);
    read(motion.at);
    read(motion.angular);
    read(motion.linear);
    read(motion.angular_acceleration);
    read(motion.linear_acceleration);
    motion.joints.resize(joints);
    for (Joint& joint : motion.joints) {
        read(joint.quat);
        read(joint.omega);
        read(joint.alpha);
        read(joint.turn);
    }
    return motion;
}

// Answers questions until the input ends.
template <class Make> int serve(Make make) {
    std::unique_ptr<Peer> peer;
    std::size_t bodies = 0;
    std::string word;
    while (std::cin >> word) {
        if (word == "rig") {
            const std::vector<Body> rig = read_rig();
            bodies = rig.size();
            peer = make(rig);
            std::puts("ready");
        } else if (word == "motion" && peer) {
            peer->set(read_motion(bodies - 1));
            std::puts("set");
        } else if (word == "found" && peer) {
            int kernel = 0;
            std::cin >> kernel;
            peer->run(kernel);
            const std::vector<double> numbers = peer->found(kernel);
            std::printf("%zu", numbers.size());
            for (double number : numbers) std::printf(" %.17g", number);
            std::puts("");
        } else if (word == "time" && peer) {
            int kernel = 0;
            long calls = 0;
            std::cin >> kernel >> calls;
            const auto start = std::chrono::steady_clock::now();
            for (long call = 0; call < calls; ++call) peer->run(kernel);
            const std::chrono::duration<double, std::nano> taken = std::chrono::steady_clock::now() - start;
            std::printf("%.17g\n", taken.count() / calls);
        } else {
            std::fprintf(stderr, "not understood: %s\n", word.c_str());
            return 2;
        }
        std::fflush(stdout);
    }
    return 0;
}
