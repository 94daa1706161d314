/// The functions of haptic.h on points, contacts and planes. They take no handle.

#include "border.hpp"
#include "convert.hpp"

using namespace haptic::c;  // every definition here is one of haptic.h
namespace client = haptic::client;

namespace {

constexpr std::size_t kMostJoints = HAPTIC_MAX_POINT_COORDINATES;
constexpr std::size_t kExpectedContacts = 32;
constexpr std::size_t kMostContacts = 1024;  // haptic_solve() says it

/// `wanted` values from `first` on, of `count`.
void within(std::size_t first, std::size_t wanted, std::size_t count) {
  if (first > count || wanted > count - first) {
    refuse("first_coordinate = " + std::to_string(first) + ": the point has " +
           std::to_string(wanted) + " coordinates, must lie within the " + std::to_string(count) +
           " of x");
  }
}

std::vector<double> coordinates(const double* x, std::size_t count, std::size_t first,
                                std::size_t wanted) {
  if (count > HAPTIC_MAX_COORDINATES) {
    refuse("count = " + std::to_string(count) + ", must be at most " +
           std::to_string(HAPTIC_MAX_COORDINATES));
  }
  within(first, wanted, count);
  return to_position(x, count, count);
}

std::size_t joints_within(std::size_t count, const char* name) {
  if (count < 1 || count > kMostJoints) {
    refuse(std::string(name) + " = " + std::to_string(count) + ", must be 1 to " +
           std::to_string(kMostJoints));
  }
  return count;
}

void write_curvature(const client::Curvature3& made, double* curvature) {
  std::copy(made.begin(), made.end(), given(curvature, "curvature"));
}

/// The caller's function as a ContactsAt.
client::ContactsAt asking(haptic_contacts_at contacts, void* user) {
  return [=](const std::vector<double>& x) {
    haptic_contact empty{};
    empty.size = sizeof empty;
    empty.point.size = sizeof empty.point;
    std::vector<haptic_contact> told(kExpectedContacts, empty);
    std::int64_t count = contacts(x.data(), x.size(), told.data(), told.size(), user);
    if (count > static_cast<std::int64_t>(told.size())) {
      told.assign(kMostContacts, empty);
      count = contacts(x.data(), x.size(), told.data(), told.size(), user);
    }
    if (count < 0) refuse("contacts gave up: it returned " + std::to_string(count));
    if (count > static_cast<std::int64_t>(kMostContacts)) {
      refuse("contacts returned " + std::to_string(count) + ", must be at most " +
             std::to_string(kMostContacts));
    }
    std::vector<client::Contact> made;
    for (std::int64_t i = 0; i < count; ++i) {
      made.push_back(to_contact(read(&told[static_cast<std::size_t>(i)], "contacts")));
    }
    return made;
  };
}

client::SolveOptions to_options(const haptic_solve_options* options, std::size_t count) {
  client::SolveOptions to;
  if (options == nullptr) return to;
  const haptic_solve_options wanted = read(options, "options");
  if (wanted.start != nullptr) to.start.assign(wanted.start, wanted.start + count);
  if (wanted.weights != nullptr) to.weights.assign(wanted.weights, wanted.weights + count);
  if (wanted.iterations != 0) to.iterations = wanted.iterations;
  if (wanted.tolerance != 0.0) to.tolerance = wanted.tolerance;
  return to;
}

double distance_from(double distance) {
  if (distance == 0.0) refuse("distance = 0, must not be 0");
  return distance;
}

}  // namespace

int haptic_point_on_finger(const double* lengths, size_t length_count, const double* x,
                           size_t count, uint32_t phalanx, double along, double palmar,
                           uint32_t first_coordinate, haptic_point* point, haptic_error* error) {
  return guarded(error, [&] {
    sized(point, "point");
    const std::size_t joints = joints_within(std::size_t{phalanx} + 1, "phalanx + 1");
    if (length_count < phalanx) {
      refuse("length_count = " + std::to_string(length_count) + ", must be at least " +
             std::to_string(phalanx) + ": one per phalanx before the point's");
    }
    if (phalanx > 0) given(lengths, "lengths");
    write(to_point(client::point_on_finger({lengths, lengths + phalanx},
                                           coordinates(x, count, first_coordinate, joints), phalanx,
                                           along, palmar, first_coordinate)),
          point);
  });
}

int haptic_point_on_joints(const haptic_joint* joints, size_t joint_count, const double position[3],
                           uint32_t first_coordinate, haptic_point* point, haptic_error* error) {
  return guarded(error, [&] {
    sized(point, "point");
    joints_within(joint_count, "joint_count");
    std::vector<client::JointAxis> chain;
    for (std::size_t j = 0; j < joint_count; ++j) {
      const haptic_joint& joint = given(joints, "joints")[j];
      chain.push_back({to_vector(joint.origin), to_vector(joint.axis), joint.prismatic != 0});
    }
    write(to_point(client::point_on_joints(chain, to_vector(given(position, "position")),
                                           first_coordinate)),
          point);
  });
}

int haptic_point_itself(const double* x, size_t count, uint32_t first_coordinate,
                        haptic_point* point, haptic_error* error) {
  return guarded(error, [&] {
    sized(point, "point");
    write(to_point(
              client::point_itself(coordinates(x, count, first_coordinate, 3), first_coordinate)),
          point);
  });
}

int haptic_point_on_pose(const double* x, size_t count, const double offset[3],
                         uint32_t first_coordinate, haptic_point* point, haptic_error* error) {
  return guarded(error, [&] {
    sized(point, "point");
    write(to_point(client::point_on_pose(coordinates(x, count, first_coordinate, 7),
                                         to_vector(given(offset, "offset")), first_coordinate)),
          point);
  });
}

int haptic_sphere_curvature(const double normal[3], double distance, double curvature[6],
                            haptic_error* error) {
  return guarded(error, [&] {
    write_curvature(
        client::sphere_curvature(to_vector(given(normal, "normal")), distance_from(distance)),
        curvature);
  });
}

int haptic_cylinder_curvature(const double normal[3], const double axis[3], double distance,
                              double curvature[6], haptic_error* error) {
  return guarded(error, [&] {
    write_curvature(
        client::cylinder_curvature(to_vector(given(normal, "normal")),
                                   to_vector(given(axis, "axis")), distance_from(distance)),
        curvature);
  });
}

int haptic_contact_at(const double* x, size_t count, const haptic_contact* contact, double coupling,
                      haptic_plane* plane, haptic_error* error) {
  return guarded(error, [&] {
    sized(plane, "plane");
    const client::Contact wanted = to_contact(read(contact, "contact"));
    if (!(coupling > 0.0)) refuse("coupling = " + std::to_string(coupling) + ", must be > 0");
    write(to_plane(client::contact_at(
              coordinates(x, count, wanted.point.first_coordinate, wanted.point.jacobian.size()),
              wanted, coupling)),
          plane);
  });
}

int haptic_contact_of_gap(const double* x, const double* gradient, size_t count, double gap,
                          haptic_plane* plane, haptic_error* error) {
  return guarded(error, [&] {
    sized(plane, "plane");
    const std::vector<double> place = coordinates(x, count, 0, 0);
    given(gradient, "gradient");
    write(to_plane(client::contact(place, gap, {gradient, gradient + count})), plane);
  });
}

double haptic_contact_horizon(int64_t round_trip_ns, int64_t period_ns, double v_max) {
  return client::contact_horizon(std::chrono::nanoseconds(round_trip_ns),
                                 std::chrono::nanoseconds(period_ns),
                                 v_max != 0.0 ? v_max : client::kFastestPoint);
}

int haptic_derive_planes(const haptic_coordinate* kinds, const double* x, const double* x_probe,
                         size_t count, const haptic_block* blocks, size_t block_count, double least,
                         haptic_plane* planes, size_t capacity, size_t* plane_count,
                         haptic_error* error) {
  return guarded(error, [&] {
    *given(plane_count, "plane_count") = 0;
    if (capacity > 0) sized(planes, "planes");
    if (block_count > 0) given(blocks, "blocks");
    const std::vector<double> proxy = coordinates(x, count, 0, 0);
    const std::vector<double> probe = coordinates(x_probe, count, 0, 0);
    std::vector<client::VirtualCoordinate> device(count);
    for (std::size_t i = 0; i < count; ++i) {
      const auto& kind = given(kinds, "coordinates")[i].kind;
      device[i].kind.assign(kind, strnlen(kind, sizeof kind));
    }
    const std::vector<client::Plane> made =
        client::derive_planes(device, proxy, probe, to_blocks(blocks, block_count), least);
    *plane_count = made.size();
    write_each(made, planes, capacity, [](const client::Plane& plane) { return to_plane(plane); });
  });
}

int haptic_solve(haptic_contacts_at contacts, void* user, const double* x_probe, size_t count,
                 double coupling, const haptic_solve_options* options, haptic_solution* solution,
                 haptic_plane* planes, size_t capacity, haptic_error* error) {
  return guarded(error, [&] {
    sized(solution, "solution");
    if (capacity > 0) sized(planes, "planes");
    const std::vector<double> probe = coordinates(x_probe, count, 0, 0);
    const client::Solution found = client::solve(asking(given(contacts, "contacts"), user), probe,
                                                 coupling, to_options(options, count));
    haptic_solution to{};
    to.converged = found.converged ? 1 : 0;
    to.iterations = found.iterations;
    write_list(found.x, to.x);
    to.plane_count = found.planes.size();
    write(to, solution);
    write_each(found.planes, planes, capacity,
               [](const client::Plane& plane) { return to_plane(plane); });
  });
}
