// A loop of Pinocchio's inverse dynamics over rows of coordinates, as a user of the C++ library writes it.
//
//   pinocchio MODEL ROWS OUT ROUNDS
//
// MODEL is a file of `saveToBinary` of Pinocchio's Python package. ROWS contains float64: all positions, then all
// speeds, then all accelerations, row after row. OUT gets the efforts.
// Standard output gets the nanoseconds per row of the best round.
#include <pinocchio/multibody.hpp>
#include <pinocchio/algorithm/rnea.hpp>
#include <pinocchio/serialization.hpp>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <vector>

int main(int count, char** arguments) {
    if (count != 5) return 2;
    pinocchio::Model model;
    model.loadFromBinary(arguments[1]);
    pinocchio::Data data(model);
    std::ifstream file(arguments[2], std::ios::binary | std::ios::ate);
    std::vector<double> numbers(std::size_t(file.tellg()) / sizeof(double));
    file.seekg(0);
    file.read(reinterpret_cast<char*>(numbers.data()), std::streamsize(numbers.size() * sizeof(double)));
    const std::size_t nq = model.nq, nv = model.nv, rows = numbers.size() / (nq + 2 * nv);
    const double *q = numbers.data(), *v = q + rows * nq, *a = v + rows * nv;
    std::vector<double> efforts(rows * nv);
    using Row = Eigen::Map<const Eigen::VectorXd>;
    double best = std::numeric_limits<double>::infinity();
    for (int round = std::atoi(arguments[4]); round > 0; --round) {
        const auto start = std::chrono::steady_clock::now();
        for (std::size_t row = 0; row < rows; ++row) {
            const Row at(q + row * nq, Eigen::Index(nq));
            const Row speed(v + row * nv, Eigen::Index(nv)), acceleration(a + row * nv, Eigen::Index(nv));
            Eigen::Map<Eigen::VectorXd>(efforts.data() + row * nv, Eigen::Index(nv)) =
                pinocchio::rnea(model, data, at, speed, acceleration);
        }
        const std::chrono::duration<double, std::nano> taken = std::chrono::steady_clock::now() - start;
        best = std::min(best, taken.count() / double(rows));
    }
    std::ofstream(arguments[3], std::ios::binary)
        .write(reinterpret_cast<const char*>(efforts.data()), std::streamsize(efforts.size() * sizeof(double)));
    std::printf("%.17g\n", best);
    return 0;
}
