/// The scene of server/demo.sh --hand in virtual time: the simulated hand wears its device, on the
/// shipped pipeline, and touches what MuJoCo simulates behind a network.

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <bit>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "hw/simulated/hand.hpp"
#include "server/owner/scene/scene.hpp"
#include "tests/mujoco/mujoco_world.hpp"

namespace haptic::mujoco {
namespace {

using core::MatXQ;
using core::VecA;
using core::VecQ;
using core::VecX;

const std::string kModel = std::string(HAPTIC_SOURCE_DIR) + "/client/mujoco/examples/hand.xml";
const std::string kScenes = std::string(HAPTIC_SOURCE_DIR) + "/server/scenes/";
const std::string kMotion = kScenes + "motion/hand_touch_stroke_grasp.csv";
const char* const kFingers[] = {"thumb", "index", "middle", "ring", "little"};
constexpr double kMotorDamping = 2.0;  // N s/m, of the simulated hand

std::vector<client::VirtualCoordinate> coordinates_of(const core::Kinematics& map) {
  std::vector<client::VirtualCoordinate> all;
  for (const core::Coordinate& one : map.space().coordinates()) all.push_back({one.name, "m", ""});
  return all;
}

/// Numeric "coupling" of the model, as haptic-example-mujoco reads it.
double coupling_of(const World& world) {
  return world.m()->numeric_data[world.m()->numeric_adr[world.id(mjOBJ_NUMERIC, "coupling")]];
}

/// The device that the hand wears, and how its simulation follows.
struct Outfit {
  std::string scene{"hand_soft_grasp.textproto"};
  std::vector<std::string> joints{};  ///< as of by_name(); none: points
  double coupling{0.0};               ///< 0: the model's
};

/// Fingers alone: the palm stands where the motion grasps the ball.
Outfit five_fingers() {
  Outfit worn{"hand_five_fingers.textproto", {}, 0.15};
  for (const std::string finger : kFingers) {
    worn.joints.push_back(finger + "_mcp=" + finger + ".q_o1_mcp");
    worn.joints.push_back(finger + "_pip=" + finger + ".q_o2_pip");
  }
  return worn;
}

/// hand.xml, with a palm that stands if there is no point to carry it.
World model_of(const Outfit& worn) {
  if (worn.joints.empty()) return World::of_file(kModel);
  std::ostringstream text;
  text << std::ifstream(kModel).rdbuf();
  std::string model = text.str();
  const std::string palm = R"(<body name="palm" pos="0 0 0.2" quat="0.70710678 0.70710678 0 0">)";
  const std::size_t at = model.find(palm), joint = model.find("<freejoint/>", at);
  model.erase(joint, std::string("<freejoint/>").size());
  model.replace(at, palm.size(),
                R"(<body name="palm" pos="-0.008 0.16 0.08" quat="0.70710678 0.70710678 0 0">)");
  return World(model);
}

/// The hand, what it wears, and its simulation.
class WornHand {
 public:
  WornHand(double rate_hz, double delay_s, const std::string& motion = kMotion,
           const Outfit& worn = {})
      : scene_(server::load_scene(kScenes + worn.scene).devices.front()),
        device_(device_of(scene_, motion)),
        config_(server::pipeline_config(scene_, device_->info().limits)),
        world(model_of(worn)),
        coupling_(worn.coupling > 0.0 ? worn.coupling : coupling_of(world)),
        bindings_(by_name(*world.m(), coordinates_of(*config_.kinematics), worn.joints)),
        tool(world.m(), world.d(), bindings_, {.coupling = coupling_}),
        loop(config_, told_by(tool, rate_hz, delay_s, config_.kinematics->space().n_x()),
             kMotorDamping) {}

  void tick() {
    device_->read(core::TimePoint(std::chrono::milliseconds(++ticks_)), reading_);
    loop.tick(reading_.sample.q);
    if (ticks_ >= 600 && ticks_ % 50 == 0 &&
        loop.record().life.state == core::LifecycleState::kArmed) {
      loop.engage();
    }
    hw::Command command;
    command.arm = true;
    command.tau_a = loop.tau_a();
    device_->write(core::TimePoint(std::chrono::milliseconds(ticks_)), command);
  }
  void run(double seconds) {
    for (int i = 0; i < static_cast<int>(1000.0 * seconds); ++i) tick();
  }
  /// Where MuJoCo presses on the hand: the pad's body, and the normal force on it, N.
  struct Press {
    int body;
    Eigen::Vector3d force, position;
  };
  [[nodiscard]] std::vector<Press> presses() const {
    constexpr int kPad = 1;  // contype
    const mjModel& m = *world.m();
    std::vector<Press> found;
    for (int i = 0; i < world.d()->ncon; ++i) {
      const mjContact& contact = world.d()->contact[i];
      const bool first = m.geom_contype[contact.geom1] == kPad;
      if (contact.efc_address < 0 || (!first && m.geom_contype[contact.geom2] != kPad)) continue;
      mjtNum force[6];
      mj_contactForce(&m, world.d(), i, force);
      if (!(force[0] > 0.0)) continue;
      found.push_back({m.geom_bodyid[first ? contact.geom1 : contact.geom2],
                       (first ? -force[0] : force[0]) * Eigen::Vector3d(contact.frame),
                       Eigen::Vector3d(contact.pos)});
    }
    return found;
  }
  /// How far MuJoCo's forces displace the bound coordinates: each by f / c of the site of its
  /// phalanx, or by its torque / c about the bound joints.
  [[nodiscard]] VecX displaced() const {
    const mjModel& m = *world.m();
    VecX dx = VecX::Zero(loop.x_probe().size());
    std::vector<mjtNum> J(3 * static_cast<std::size_t>(m.nv));
    for (const Press& press : presses()) {
      mj_jac(&m, world.d(), J.data(), nullptr, press.position.data(), press.body);
      for (const Binding& binding : bindings_) {
        const auto first = static_cast<Eigen::Index>(binding.first_coordinate);
        if (binding.kind == Binding::Kind::kJoint) {
          const int dof = m.jnt_dofadr[world.id(mjOBJ_JOINT, binding.name.c_str())];
          for (int k = 0; k < 3; ++k) dx[first] += press.force[k] * J[k * m.nv + dof] / coupling_;
          continue;
        }
        const int site = mj_name2id(&m, mjOBJ_SITE, binding.name.c_str());
        if (m.site_bodyid[site] != m.body_parentid[press.body]) continue;
        dx.segment<3>(first) += press.force / coupling_;
      }
    }
    return dx;
  }
  /// That force at the motors. Points: Eq. (8) renders Z_q S J^+ dx. Joints: Eq. (6) renders
  /// Z_q S (q* - q) with f(q*) = x. `left`: the part of dx that the device has no DoF for, of all.
  [[nodiscard]] VecA engine_force(double& left) const {
    const VecX dx = displaced();
    VecQ q_star = reading_.sample.q;
    if (bindings_.front().kind == Binding::Kind::kJoint) {
      EXPECT_EQ(config_.kinematics->inverse(loop.x_probe() + dx, q_star),
                core::InverseStatus::kExact);
      left = 0.0;
    } else {
      const Eigen::MatrixXd J = loop.J();
      const VecQ dq = J.colPivHouseholderQr().solve(Eigen::VectorXd(dx));
      left = (dx - J * dq).norm() / dx.norm();
      q_star += dq;
    }
    return config_.scene.stiffness.cwiseProduct(
        config_.kinematics->layout().select(VecQ(q_star - reading_.sample.q)));
  }
  [[nodiscard]] double height(const char* body) const {
    return world.d()->xpos[3 * world.id(mjOBJ_BODY, body) + 2];
  }
  [[nodiscard]] double tank() const { return config_.passivity.tank.initial; }

 private:
  static std::unique_ptr<hw::Device> device_of(const server::DeviceScene& scene,
                                               const std::string& motion) {
    auto source = dynamic_cast<const hw::SimulatedHandConfig&>(*scene.source);
    source.motion_file = motion;
    return source.open(scene.pipeline.kinematics, {});
  }

  server::DeviceScene scene_;
  std::unique_ptr<hw::Device> device_;
  core::PipelineConfig config_;
  core::DeviceReading reading_{};
  int ticks_{0};

 public:
  World world;

 private:
  double coupling_;
  std::vector<Binding> bindings_;

 public:
  Tool tool;
  test::PipelineLoop loop;
};

/// Palm and joints put where the device's map has them, every site is where the map has its output.
TEST(MujocoHand, HasTheDevicesDimensions) {
  const auto scene = server::load_scene(kScenes + "hand_soft_grasp.textproto");
  const core::Kinematics& map = *scene.devices.front().pipeline.kinematics;
  World world = World::of_file(kModel);
  const auto bindings = by_name(*world.m(), coordinates_of(map));
  ASSERT_EQ(bindings.size(), 13u);
  for (const double part : {0.0, 0.3, 0.6, 0.9}) {
    VecQ q = VecQ::Zero(16);
    q.head<6>() << 0.1, -0.05, 0.2, 0.3 + part, -0.2, 0.4;
    const Eigen::Vector3d turn = q.segment<3>(3);
    mjtNum* const palm =
        world.d()->qpos +
        world.m()->jnt_qposadr[world.m()->body_jntadr[world.id(mjOBJ_BODY, "palm")]];
    std::copy_n(q.data(), 3, palm);
    const Eigen::Vector3d axis = turn.normalized();
    mju_axisAngle2Quat(palm + 3, axis.data(), turn.norm());
    for (int finger = 0; finger < 5; ++finger) {
      const core::DofSpec& slider = map.dofs()[static_cast<std::size_t>(6 + 2 * finger)];
      q[6 + 2 * finger] = slider.lower + (0.1 + 0.8 * part) * (slider.upper - slider.lower);
      q[7 + 2 * finger] = 0.1;
      VecX joints;
      MatXQ J;
      const core::Mechanism& of = map.mechanisms()[static_cast<std::size_t>(finger)];
      ASSERT_EQ(of.kinematics->evaluate(q.segment(of.first_q, 2), joints, J), core::MapStatus::kOk);
      for (int joint = 0; joint < 2; ++joint) {
        const std::string name = std::string(kFingers[finger]) + (joint == 0 ? "_mcp" : "_pip");
        const int id = world.id(mjOBJ_JOINT, name.c_str());
        world.d()->qpos[world.m()->jnt_qposadr[id]] = joints[joint];
      }
    }
    mj_kinematics(world.m(), world.d());
    VecX x;
    MatXQ J;
    ASSERT_EQ(map.evaluate(q, x, J), core::MapStatus::kOk);
    for (const Binding& binding : bindings) {
      const mjtNum* const site =
          world.d()->site_xpos + 3 * world.id(mjOBJ_SITE, binding.name.c_str());
      for (int k = 0; k < 3; ++k) {
        EXPECT_NEAR(site[k], x[static_cast<Eigen::Index>(binding.first_coordinate) + k], 1e-9)
            << binding.name;
      }
    }
  }
}

/// The whole motion: ball, box and cup.
TEST(MujocoHand, TouchesStrokesAndGrasps) {
  WornHand hand(60.0, 0.0);
  const double box = hand.world.d()->xpos[3 * hand.world.id(mjOBJ_BODY, "box")];
  VecA most = VecA::Zero(5);
  std::size_t at_once = 0;
  double free_force = 0.0, lifted = 0.0;
  int since_contact = 0;
  for (int i = 0; i < 25000; ++i) {
    hand.tick();
    const core::TickRecord& record = hand.loop.record();
    ASSERT_FALSE(record.life.faults.any()) << i;
    const auto held = static_cast<std::size_t>(std::popcount(record.anchor.active_planes));
    since_contact = held > 0 ? 0 : since_contact + 1;
    at_once = std::max(at_once, hand.presses().size());
    most = most.cwiseMax(hand.loop.tau_a().cwiseAbs());
    if (since_contact > 200) {
      free_force = std::max(free_force, hand.loop.tau_a().cwiseAbs().maxCoeff());
    }
    lifted = std::max(lifted, hand.height("cup"));
  }
  EXPECT_GE(at_once, 10u);
  EXPECT_GT(most.minCoeff(), 0.3) << most.transpose();
  EXPECT_LE(free_force, 0.02 * most.maxCoeff());
  EXPECT_LE(hand.loop.energy().most_net(), hand.tank());
  EXPECT_LT(hand.world.d()->xpos[3 * hand.world.id(mjOBJ_BODY, "box")], box - 0.03) << "pushed";
  EXPECT_GT(lifted, 0.075) << "the cup, from 25 mm";
  EXPECT_NEAR(hand.height("cup"), 0.025, 0.002) << "it stands again";
}

/// The motion up to its first grasp, of the ball, which is held for `seconds`.
std::string motion_that_holds(double seconds) {
  std::ifstream file(kMotion);
  std::ostringstream out;
  std::string line;
  std::getline(file, line);
  out << line << '\n';
  while (std::getline(file, line)) {
    out << line << '\n';
    if (std::stod(line) < 3.3) continue;
    out << 3.3 + seconds << line.substr(line.find(',')) << '\n';
    return out.str();
  }
  throw std::runtime_error("the motion has no grasp");
}

void hold(const Outfit& worn, std::size_t least_presses) {
  const double seconds = hold_seconds(2.0);
  const test::TemporaryFile motion(motion_that_holds(seconds + 1.0), "hold.csv");
  for (const double rate : {60.0, 120.0, 500.0}) {
    for (const double delay : {0.0, 0.040, 0.100}) {
      SCOPED_TRACE(std::to_string(rate) + "/s, " + std::to_string(delay) + " s");
      WornHand hand(rate, delay, motion.path(), worn);
      hand.run(4.0 + 0.5 * seconds);
      double off = 0.0, most = 0.0, left = 0.0;
      for (int i = 0; i < static_cast<int>(500.0 * seconds); ++i) {
        hand.tick();
        const VecA engine = hand.engine_force(left);
        off = std::max(off, (hand.loop.tau_a() - engine).cwiseAbs().maxCoeff());
        most = std::max(most, engine.cwiseAbs().maxCoeff());
      }
      std::printf("%3.0f/s, %3.0f ms: %.2f N, off by %.2f %%, %.0f %% cannot be rendered\n", rate,
                  1e3 * delay, most, 100.0 * off / most, 100.0 * left);
      EXPECT_GT(most, 2.0);
      EXPECT_LE(off, 0.02 * most);
      EXPECT_GE(hand.presses().size(), least_presses);
      EXPECT_LE(hand.loop.energy().most_net(), hand.tank());
    }
  }
}

/// HAPTIC_HOLD_S=60 holds for as long as that.
TEST(MujocoHand, HeldForceIsMujocos) {
  hold({}, 8);
}

TEST(MujocoHand, HeldByFingersAlone) {
  hold(five_fingers(), 5);
}

}  // namespace
}  // namespace haptic::mujoco
