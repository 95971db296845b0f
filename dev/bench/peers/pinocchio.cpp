// Pinocchio with SCALAR (double or float) numbers: its header-only templates, compiled as by a C++ user.
#include <pinocchio/multibody.hpp>
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/algorithm/rnea.hpp>

#include "peer.hpp"

using Scalar = SCALAR;
using Model = pinocchio::ModelTpl<Scalar>;
using Data = pinocchio::DataTpl<Scalar>;
using SE3 = pinocchio::SE3Tpl<Scalar>;
using Inertia = pinocchio::InertiaTpl<Scalar>;
using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
using Vector3 = Eigen::Matrix<Scalar, 3, 1>;
using Matrix3 = Eigen::Matrix<Scalar, 3, 3>;
using Quaternion = Eigen::Quaternion<Scalar>;

static Vector3 vector(const double (&v)[3]) {
    return Vector3(Scalar(v[0]), Scalar(v[1]), Scalar(v[2]));
}

static Quaternion quaternion(const double (&q)[4]) {
    return Quaternion(Scalar(q[3]), Scalar(q[0]), Scalar(q[1]), Scalar(q[2]));
}

class Pinocchio : public Peer {
public:
    explicit Pinocchio(const std::vector<Body>& bodies) {
        joints.resize(bodies.size());
        add(bodies, 0);
        for (const Body& body : bodies) kinds.push_back(body.joint);
        model.gravity.linear() = Vector3(0, 0, Scalar(-9.80665));
        data = Data(model);
        q = Vector::Zero(model.nq);
        v = a = tau = Vector::Zero(model.nv);
    }

    void set(const Motion& motion) override {
        q.template head<3>() = vector(motion.at);
        q.template segment<4>(3) = quaternion(motion.quat).coeffs();
        v.template head<3>() = vector(motion.linear);
        v.template segment<3>(3) = vector(motion.angular);
        // The derivative of the components in body axes is the classical acceleration minus that of the turning axes.
        a.template head<3>() =
            vector(motion.linear_acceleration) - vector(motion.angular).cross(vector(motion.linear));
        a.template segment<3>(3) = vector(motion.angular_acceleration);
        for (std::size_t body = 1; body < kinds.size(); ++body) {
            const Joint& joint = motion.joints[body - 1];
            const auto& of_model = model.joints[joints[body]];
            const int at_q = of_model.idx_q(), at_v = of_model.idx_v();
            if (kinds[body] == BALL) {
                q.template segment<4>(at_q) = quaternion(joint.quat).coeffs();
                v.template segment<3>(at_v) = vector(joint.omega);
                a.template segment<3>(at_v) = vector(joint.alpha);
            } else {
                q[at_q] = Scalar(joint.turn[0]);
                v[at_v] = Scalar(joint.turn[1]);
                a[at_v] = Scalar(joint.turn[2]);
            }
        }
        run(RNEA);
        tau = data.tau;
    }

    void run(int kernel) override {
        switch (kernel) {
        case RNEA: pinocchio::rnea(model, data, q, v, a); break;
        case ABA: pinocchio::aba(model, data, q, v, tau); break;
        case CRBA: pinocchio::crba(model, data, q); break;
        default: pinocchio::forwardKinematics(model, data, q, v);
        }
    }

    std::vector<double> found(int kernel) override {
        if (kernel == CRBA) {
            // Only its upper triangle is filled.
            const Vector momentum = data.M.template selfadjointView<Eigen::Upper>() * v;
            return {double(Scalar(0.5) * v.dot(momentum))};
        }
        if (kernel == FK) {
            const Vector3 at = data.oMi[joints.back()].translation();
            return {double(at[0]), double(at[1]), double(at[2])};
        }
        Vector all = kernel == RNEA ? data.tau : data.ddq;
        if (kernel == ABA) all.template head<3>() += v.template segment<3>(3).cross(v.template head<3>());
        std::vector<double> numbers;
        for (int k : {3, 4, 5, 0, 1, 2}) numbers.push_back(double(all[k]));
        for (std::size_t body = 1; body < kinds.size(); ++body) {
            const int at = model.joints[joints[body]].idx_v(), count = kinds[body] == BALL ? 3 : 1;
            for (int k = 0; k < count; ++k) numbers.push_back(double(all[at + k]));
        }
        return numbers;
    }

private:
    // Adds a body and its descendants: the mass matrix needs joints in depth-first order.
    void add(const std::vector<Body>& bodies, std::size_t index) {
        const Body& body = bodies[index];
        const std::string name = "b" + std::to_string(index);
        const SE3 placement(quaternion(body.quat), vector(body.at));
        pinocchio::JointIndex& joint = joints[index];
        if (body.joint == FREE) {
            joint = model.addJoint(0, pinocchio::JointModelFreeFlyerTpl<Scalar>(), SE3::Identity(), name);
        } else if (body.joint == BALL) {
            const pinocchio::JointModelSphericalTpl<Scalar> ball;
            joint = model.addJoint(joints[body.parent], ball, placement, name);
        } else {
            const pinocchio::JointModelRevoluteUnalignedTpl<Scalar> revolute(vector(body.axis));
            joint = model.addJoint(joints[body.parent], revolute, placement, name);
        }
        const double* i = body.inertia;
        Matrix3 about_center;
        about_center << Scalar(i[0]), Scalar(i[1]), Scalar(i[2]), Scalar(i[1]), Scalar(i[3]), Scalar(i[4]),
            Scalar(i[2]), Scalar(i[4]), Scalar(i[5]);
        const Inertia inertia(Scalar(body.mass), vector(body.center), about_center);
        model.appendBodyToJoint(joint, inertia, SE3::Identity());
        for (std::size_t child = index + 1; child < bodies.size(); ++child) {
            if (bodies[child].parent == int(index)) add(bodies, child);
        }
    }

    Model model;
    Data data;
    std::vector<int> kinds;
    // Index of Pinocchio's joint for each of our bodies.
    std::vector<pinocchio::JointIndex> joints;
    Vector q, v, a, tau;
};

int main() {
    return serve([](const std::vector<Body>& bodies) { return std::make_unique<Pinocchio>(bodies); });
}
