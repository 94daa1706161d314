#include "near_contacts.hpp"

#include <algorithm>
#include <string>

#include "haptic/mujoco/contact_spring.hpp"
#include "words.hpp"

namespace haptic::mujoco {

namespace {

double gap_of(const mjContact& contact) {
  return contact.dist - contact.includemargin;
}

std::pair<int, int> pair_of(const mjContact& contact) {
  return std::minmax({contact.geom1, contact.geom2});
}

/// How far the surface is from the point or line that carries it: a round geom's radius.
double radius_of(const mjModel& model, int geom) {
  const int type = model.geom_type[geom];
  return type == mjGEOM_SPHERE || type == mjGEOM_CAPSULE ? model.geom_size[3 * geom] : 0.0;
}

/// Round bodies whose middles are closer have no curvature at this point, m; they are told as flat.
constexpr double kLeastApart = 1e-6;

/// Curvature of the object's gap to the centre of a round part of the tool, `from_surface` away
/// from it.
client::Curvature3 curvature_of(const mjModel& model, const mjData& data, int geom,
                                const Vector3& normal, const Vector3& surface,
                                double from_surface) {
  const int type = model.geom_type[geom];
  const mjtNum* size = model.geom_size + 3 * geom;
  if (size[0] + from_surface < kLeastApart) return {};
  if (type == mjGEOM_SPHERE) return client::sphere_curvature(normal, size[0] + from_surface);
  if (type != mjGEOM_CAPSULE && type != mjGEOM_CYLINDER) return {};
  const mjtNum* frame = data.geom_xmat + 9 * geom;
  const Vector3 axis{frame[2], frame[5], frame[8]};
  const Vector3 from = add(surface, -1.0, vector_at(data.geom_xpos + 3 * geom));
  const bool beside = std::abs(dot(axis, from)) < size[1] && std::abs(dot(axis, normal)) < 1e-3;
  if (beside) return client::cylinder_curvature(normal, axis, size[0] + from_surface);
  return type == mjGEOM_CAPSULE ? client::sphere_curvature(normal, size[0] + from_surface)
                                : client::Curvature3{};
}

/// a less b, of points that different coordinates may move: how the way between them changes.
client::PointMap difference(const client::PointMap& a, const client::PointMap& b) {
  const std::size_t low = std::min(a.first_coordinate, b.first_coordinate);
  const std::size_t high =
      std::max(a.first_coordinate + a.jacobian.size(), b.first_coordinate + b.jacobian.size());
  client::PointMap out{low, a.position, std::vector<Vector3>(high - low), {}};
  if (high - low <= kMostCurved && !a.second.empty() && !b.second.empty()) {
    out.second.resize(triangle(high - low, 0));
  }
  for (const auto& [map, sign] : {std::pair{&a, 1.0}, {&b, -1.0}}) {
    const std::size_t shift = map->first_coordinate - low;
    for (std::size_t j = 0; j < map->jacobian.size(); ++j) {
      out.jacobian[shift + j] = add(out.jacobian[shift + j], sign, map->jacobian[j]);
      for (std::size_t k = 0; k <= j && !out.second.empty(); ++k) {
        Vector3& entry = out.second[triangle(shift + j, shift + k)];
        entry = add(entry, sign, map->second[triangle(j, k)]);
      }
    }
  }
  return out;
}

/// Where a contact is in the frame of a geom, m.
Vector3 in_geom(const mjData& data, int geom, const Vector3& position) {
  const Vector3 from = add(position, -1.0, vector_at(data.geom_xpos + 3 * geom));
  mjtNum out[3];
  mju_mulMatTVec(out, data.geom_xmat + 9 * geom, from.data(), 3, 3);
  return vector_at(out);
}

}  // namespace

bool NearContacts::is_of_tool(const mjModel& model, const mjContact& contact) const {
  constexpr int kInGap = 1;  // of mjContact::exclude; beyond it is not a contact
  if (contact.geom1 < 0 || contact.geom2 < 0 || contact.exclude > kInGap) return false;
  return tool_->moves(model.geom_bodyid[contact.geom1]) ||
         tool_->moves(model.geom_bodyid[contact.geom2]);
}

void NearContacts::begin(const mjModel& model, const mjData& data) {
  inside_.clear();
  for (int i = 0; i < data.ncon; ++i) {
    const mjContact& contact = data.contact[i];
    if (is_of_tool(model, contact) && gap_of(contact) < 0.0) inside_.insert(pair_of(contact));
  }
  if (inside_.empty() || warned_) return;
  warned_ = true;
  const auto [a, b] = *inside_.begin();
  std::string text = name_of(model, a) + " and " + name_of(model, b);
  if (inside_.size() > 1) text += " and " + std::to_string(inside_.size() - 1) + " other pair(s)";
  warn(text + " begin inside each other: they are not felt until they were apart");
}

std::vector<NearContact> NearContacts::find(const mjModel& model, mjData& data,
                                            const std::vector<double>& x,
                                            const std::vector<mjtNum>& rate) {
  if (!inside_.empty()) {
    std::set<std::pair<int, int>> still;
    for (int i = 0; i < data.ncon; ++i) {
      if (gap_of(data.contact[i]) < 0.0) still.insert(pair_of(data.contact[i]));
    }
    std::erase_if(inside_, [&](const auto& pair) { return !still.contains(pair); });
  }
  std::vector<int> near_ones;
  std::set<int> bodies;  // that the tool may push
  for (int i = 0; i < data.ncon; ++i) {
    const mjContact& c = data.contact[i];
    if (!is_of_tool(model, c) || inside_.contains(pair_of(c))) continue;
    near_ones.push_back(i);
    for (const int geom : {c.geom1, c.geom2}) {
      if (!tool_->moves(model.geom_bodyid[geom])) bodies.insert(model.geom_bodyid[geom]);
    }
  }
  ids_.begin();
  surroundings_.look(model, data, rate, bodies);
  std::vector<NearContact> found(near_ones.size());
  std::vector<PushedObject> pushed;
  auto near = found.begin();
  for (const int i : near_ones) {
    const mjContact& c = data.contact[i];
    const bool second = tool_->moves(model.geom_bodyid[c.geom2]);
    const int geom = second ? c.geom2 : c.geom1, other = second ? c.geom1 : c.geom2;
    const int body = model.geom_bodyid[geom], object = model.geom_bodyid[other];
    auto& [told, pressing] = *near++;
    told.normal = add({}, second ? 1.0 : -1.0, vector_at(c.frame));
    told.gap = gap_of(c);
    const double radius = radius_of(model, geom);
    const Vector3 middle = vector_at(c.pos);
    const Vector3 surface = add(middle, 0.5 * c.dist, told.normal);
    const Vector3 beyond = add(middle, -0.5 * c.dist, told.normal);
    told.point = tool_->point_on(data, body, add(surface, radius, told.normal), x);
    double give = tool_->give(data, body, surface, told.normal);
    if (c.efc_address >= 0) {
      mjtNum force[6];
      mj_contactForce(&model, &data, i, force);
      pressing = force[0];
    }
    if (tool_->moves(object)) {
      const double other_radius = radius_of(model, other);
      const Vector3 middle_of_other = add(beyond, -other_radius, told.normal);
      told.point = difference(told.point, tool_->point_on(data, object, middle_of_other, x));
      const double apart = radius + c.dist + other_radius;
      if (radius > 0.0 && other_radius > 0.0 && apart >= kLeastApart &&
          told.point.jacobian.size() <= kMostCurved) {
        told.curvature = client::sphere_curvature(told.normal, apart);
      }
      give += tool_->give(data, object, beyond, told.normal);
    } else {
      if (radius > 0.0 && told.point.jacobian.size() <= kMostCurved) {
        told.curvature = curvature_of(model, data, other, told.normal, beyond, c.dist + radius);
      }
      auto way = surroundings_.object(model, data, object, beyond, pressing, told);
      if (way) pushed.push_back(*std::move(way));
    }
    if (radius == 0.0) told.point.second.clear();  // the place of contact moves along the tool
    told.stiffness = 1.0 / (1.0 / ContactSpring(model, c).stiffness(-told.gap) + give);
    told.id = ids_.id(pair_of(c), in_geom(data, geom, surface));
  }
  Surroundings::share(pushed);
  return found;
}

}  // namespace haptic::mujoco
