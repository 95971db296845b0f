// MuJoCo: the stages of its pipeline that a kernel needs, without contacts. It has no articulated-body algorithm: its
// forward dynamics computes the mass matrix, factors it and solves.
#include <mujoco/mujoco.h>

#include <cmath>
#include <cstring>
#include <sstream>

#include "peer.hpp"

// Writes the model's text, with each body inside its parent.
static void write(std::ostringstream& xml, const std::vector<Body>& bodies, std::size_t index) {
    const Body& body = bodies[index];
    const bool root = body.joint == FREE;
    const auto list = [&xml](std::initializer_list<double> numbers) {
        for (double number : numbers) xml << number << ' ';
    };
    xml << "<body name=\"b" << index << "\" pos=\"";
    if (root) list({0, 0, 0}); else list({body.at[0], body.at[1], body.at[2]});
    xml << "\" quat=\"";
    if (root) list({1, 0, 0, 0}); else list({body.quat[3], body.quat[0], body.quat[1], body.quat[2]});
    xml << "\">";
    if (root) {
        xml << "<freejoint/>";
    } else if (body.joint == BALL) {
        xml << "<joint type=\"ball\"/>";
    } else {
        xml << "<joint type=\"hinge\" axis=\"";
        list({body.axis[0], body.axis[1], body.axis[2]});
        xml << "\"/>";
    }
    const double* i = body.inertia;
    xml << "<inertial pos=\"";
    list({body.center[0], body.center[1], body.center[2]});
    xml << "\" mass=\"" << body.mass << "\" fullinertia=\"";
    list({i[0], i[3], i[5], i[1], i[2], i[4]});
    xml << "\"/>";
    for (std::size_t child = index + 1; child < bodies.size(); ++child) {
        if (bodies[child].parent == int(index)) write(xml, bodies, child);
    }
    xml << "</body>";
}

static void turned(const double* quat_wxyz, const double (&v)[3], mjtNum* out) {
    mju_rotVecQuat(out, v, quat_wxyz);
}

class MuJoCo : public Peer {
public:
    explicit MuJoCo(const std::vector<Body>& bodies) {
        std::ostringstream xml;
        xml.precision(17);
        xml << "<mujoco><compiler angle=\"radian\"/><option gravity=\"0 0 -9.80665\"/><worldbody>";
        write(xml, bodies, 0);
        xml << "</worldbody></mujoco>";
        char error[1000] = "";
        mjSpec* spec = mj_parseXMLString(xml.str().c_str(), nullptr, error, sizeof error);
        model = spec ? mj_compile(spec, nullptr) : nullptr;
        if (!model) {
            std::fprintf(stderr, "MuJoCo refuses the rig: %s\n", error);
            std::exit(2);
        }
        mj_deleteSpec(spec);
        data = mj_makeData(model);
        for (std::size_t index = 0; index < bodies.size(); ++index) {
            const int body = mj_name2id(model, mjOBJ_BODY, ("b" + std::to_string(index)).c_str());
            ids.push_back(body);
            kinds.push_back(bodies[index].joint);
        }
        forces.resize(model->nv);
        torques.resize(model->nv);
        dense.resize(std::size_t(model->nv) * model->nv);
    }

    ~MuJoCo() override {
        mj_deleteData(data);
        mj_deleteModel(model);
    }

    void set(const Motion& motion) override {
        for (int k = 0; k < 3; ++k) data->qpos[k] = motion.at[k];
        wxyz(motion.quat, root);
        std::memcpy(data->qpos + 3, root, sizeof root);
        // Linear motion of a free joint is in world axes, angular motion in body axes.
        turned(root, motion.linear, data->qvel);
        turned(root, motion.linear_acceleration, data->qacc);
        for (int k = 0; k < 3; ++k) {
            data->qvel[3 + k] = motion.angular[k];
            data->qacc[3 + k] = motion.angular_acceleration[k];
        }
        for (std::size_t body = 1; body < kinds.size(); ++body) {
            const Joint& joint = motion.joints[body - 1];
            const int id = model->body_jntadr[ids[body]];
            mjtNum* q = data->qpos + model->jnt_qposadr[id];
            const int dof = model->jnt_dofadr[id];
            if (kinds[body] == BALL) {
                wxyz(joint.quat, q);
                std::memcpy(data->qvel + dof, joint.omega, sizeof joint.omega);
                std::memcpy(data->qacc + dof, joint.alpha, sizeof joint.alpha);
            } else {
                *q = joint.turn[0];
                data->qvel[dof] = joint.turn[1];
                data->qacc[dof] = joint.turn[2];
            }
        }
        run(RNEA);
        torques = forces;
    }

    void run(int kernel) override {
        mj_kinematics(model, data);
        mj_comPos(model, data);
        switch (kernel) {
        case RNEA:
            mj_comVel(model, data);
            mj_rne(model, data, 1, forces.data());
            break;
        case ABA:
            mj_comVel(model, data);
            mj_makeM(model, data);
            mj_factorM(model, data);
            mj_rne(model, data, 0, forces.data());
            for (int k = 0; k < model->nv; ++k) forces[k] = torques[k] - forces[k];
            mj_solveM(model, data, accelerations(), forces.data(), 1);
            break;
        case CRBA: mj_makeM(model, data); break;
        default: mj_comVel(model, data);
        }
    }

    std::vector<double> found(int kernel) override {
        if (kernel == CRBA) {
            mj_fullM(model, data, dense.data());
            double energy = 0.0;
            for (int row = 0; row < model->nv; ++row) {
                for (int column = 0; column < model->nv; ++column) {
                    energy += 0.5 * dense[std::size_t(row) * model->nv + column] * data->qvel[row] * data->qvel[column];
                }
            }
            return {energy};
        }
        if (kernel == FK) {
            const mjtNum* at = data->xpos + 3 * ids.back();
            return {at[0], at[1], at[2]};
        }
        const mjtNum* all = kernel == RNEA ? forces.data() : accelerations();
        std::vector<double> numbers(all + 3, all + 6);
        double back[4], in_body[3];
        const double linear[3] = {all[0], all[1], all[2]};
        mju_negQuat(back, root);
        turned(back, linear, in_body);
        numbers.insert(numbers.end(), in_body, in_body + 3);
        for (std::size_t body = 1; body < kinds.size(); ++body) {
            const int dof = model->body_dofadr[ids[body]], count = kinds[body] == BALL ? 3 : 1;
            numbers.insert(numbers.end(), all + dof, all + dof + count);
        }
        return numbers;
    }

private:
    static void wxyz(const double (&quat)[4], mjtNum* out) {
        out[0] = quat[3];
        for (int k = 0; k < 3; ++k) out[k + 1] = quat[k];
    }

    mjtNum* accelerations() { return data->qacc_smooth; }

    mjModel* model = nullptr;
    mjData* data = nullptr;
    double root[4] = {1, 0, 0, 0};
    std::vector<int> ids, kinds;
    std::vector<mjtNum> forces, torques, dense;
};

int main() {
    return serve([](const std::vector<Body>& bodies) { return std::make_unique<MuJoCo>(bodies); });
}
