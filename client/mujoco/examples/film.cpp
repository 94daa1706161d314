#include "film.hpp"

#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <tuple>

namespace haptic::examples {

namespace {

constexpr int kWidth = 1280, kHeight = 720, kGeoms = 2000;
constexpr double kArrow = 0.08;  // m per N
constexpr float kGhost = 0.45F;  // opacity of the probe
constexpr float kRed[4] = {0.85F, 0.10F, 0.12F, 1.0F};

/// A context of OpenGL without a screen.
class OffScreen {
 public:
  OffScreen() {
    const auto platform_display = reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(
        eglGetProcAddress("eglGetPlatformDisplayEXT"));
    if (platform_display != nullptr) {
      display_ = platform_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
    }
    const EGLint wanted[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE,
                             EGL_OPENGL_BIT,   EGL_DEPTH_SIZE,  24,
                             EGL_NONE};
    EGLConfig config = nullptr;
    EGLint count = 0;
    if (display_ == EGL_NO_DISPLAY || eglInitialize(display_, nullptr, nullptr) == EGL_FALSE ||
        eglChooseConfig(display_, wanted, &config, 1, &count) == EGL_FALSE || count == 0 ||
        eglBindAPI(EGL_OPENGL_API) == EGL_FALSE) {
      throw std::runtime_error("no film: EGL has no driver that draws without a screen");
    }
    context_ = eglCreateContext(display_, config, EGL_NO_CONTEXT, nullptr);
    if (eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_FALSE) {
      throw std::runtime_error("no film: EGL gave no context");
    }
  }
  ~OffScreen() {
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display_, context_);
    eglTerminate(display_);
  }
  OffScreen(const OffScreen&) = delete;
  OffScreen& operator=(const OffScreen&) = delete;

 private:
  EGLDisplay display_{EGL_NO_DISPLAY};
  EGLContext context_{EGL_NO_CONTEXT};
};

/// ffmpeg, which gets pictures and writes a file.
class Encoder {
 public:
  Encoder(const std::string& file, const std::string& codec) {
    setenv("HAPTIC_FILM", file.c_str(), 1);  // needs no quoting
    const std::string command = "ffmpeg -y -loglevel error -f rawvideo -pix_fmt rgb24 -r 30 -s " +
                                std::to_string(kWidth) + "x" + std::to_string(kHeight) +
                                " -i - -vf vflip " + codec + " \"$HAPTIC_FILM\"";
    pipe_ = popen(command.c_str(), "w");
    if (pipe_ == nullptr) throw std::runtime_error("no film: ffmpeg did not start");
  }
  ~Encoder() {
    if (pipe_ != nullptr) pclose(pipe_);
  }
  Encoder(const Encoder&) = delete;
  Encoder& operator=(const Encoder&) = delete;

  void add(const std::vector<unsigned char>& picture) {
    std::fwrite(picture.data(), 1, picture.size(), pipe_);
  }
  void end() {
    FILE* const pipe = std::exchange(pipe_, nullptr);
    if (pclose(pipe) != 0) throw std::runtime_error("no film: ffmpeg failed (is it installed?)");
  }

 private:
  FILE* pipe_{nullptr};
};

/// Draws one frame after another, in time.
class Stage {
 public:
  Stage(mjModel& model, const std::vector<mujoco::Binding>& bindings,
        const mujoco::ToolOptions& coupled, const client::DeviceInfo& device)
      : proxy_(&model),
        data_(mj_makeData(&model), mj_deleteData),
        ghost_model_(mj_copyModel(nullptr, &model), mj_deleteModel),
        ghost_(mj_makeData(ghost_model_.get()), mj_deleteData) {
    // The probe is where the tool would be if nothing were in its way.
    ghost_model_->opt.disableflags |= mjDSBL_CONTACT;
    tool_.emplace(ghost_model_.get(), ghost_.get(), bindings, coupled);
    for (const client::DegreeOfFreedom& dof : device.dofs) {
      if (dof.actuated)
        motors_.push_back({dof.name.substr(0, dof.name.find('.')), dof.unit == "m" ? "N" : "N m"});
    }
    model.vis.global.offwidth = kWidth;
    model.vis.global.offheight = kHeight;
    mjv_defaultScene(&scene_);
    mjv_defaultOption(&look_);
    mjv_defaultCamera(&camera_);
    mjr_defaultContext(&context_);
    mjv_makeScene(&model, &scene_, kGeoms);
    mjr_makeContext(&model, &context_, mjFONTSCALE_150);
    mjr_setBuffer(mjFB_OFFSCREEN, &context_);
    camera_.type = model.ncam > 0 ? mjCAMERA_FIXED : mjCAMERA_FREE;
    camera_.fixedcamid = 0;
    if (model.ncam == 0) mjv_defaultFreeCamera(&model, &camera_);
  }
  ~Stage() {
    mjr_freeContext(&context_);
    mjv_freeScene(&scene_);
  }
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;

  void advance(const FilmFrame& frame) { tool_->step(frame.x_probe, 1.0 / 60.0); }

  const std::vector<unsigned char>& draw(const FilmFrame& frame, double most_force) {
    std::copy(frame.qpos.begin(), frame.qpos.end(), data_->qpos);
    mj_kinematics(proxy_, data_.get());
    mj_comPos(proxy_, data_.get());
    mj_camlight(proxy_, data_.get());
    mjv_updateScene(proxy_, data_.get(), &look_, nullptr, &camera_, mjCAT_ALL, &scene_);
    add_ghost();
    for (const Touch& touch : frame.touches) add_arrow(touch);
    const mjrRect view = {0, 0, kWidth, kHeight};
    mjr_render(view, &scene_, &context_);
    draw_bars(frame, most_force);
    mjr_readPixels(pixels_.data(), nullptr, view, &context_);
    return pixels_;
  }

 private:
  void add_ghost() {
    const int first = scene_.ngeom;
    mjv_addGeoms(ghost_model_.get(), ghost_.get(), &look_, nullptr, mjCAT_DYNAMIC, &scene_);
    int kept = first;
    for (int i = first; i < scene_.ngeom; ++i) {
      mjvGeom geom = scene_.geoms[i];
      if (geom.objtype != mjOBJ_GEOM || !tool_->moves(ghost_model_->geom_bodyid[geom.objid])) {
        continue;
      }
      const float blue[4] = {0.25F, 0.45F, 0.9F, kGhost};
      std::copy(blue, blue + 4, geom.rgba);
      for (float& size : geom.size)
        size = std::max(0.5F * size, size - 0.0015F);  // inside the proxy
      geom.transparent = 1;
      scene_.geoms[kept++] = geom;
    }
    scene_.ngeom = kept;
  }

  void add_arrow(const Touch& touch) {
    const double force = mju_norm3(touch.force);
    if (scene_.ngeom >= scene_.maxgeom || force * kArrow < 0.004) return;
    mjtNum along[3], size[3] = {0.002, 0.002, force * kArrow}, quaternion[4], frame[9];
    mju_copy3(along, touch.force);
    mju_normalize3(along);
    mju_quatZ2Vec(quaternion, along);
    mju_quat2Mat(frame, quaternion);
    mjvGeom* const geom = scene_.geoms + scene_.ngeom++;
    mjv_initGeom(geom, mjGEOM_ARROW, size, touch.position, frame, kRed);
    geom->category = mjCAT_DECOR;
  }

  void draw_bars(const FilmFrame& frame, double most) {
    constexpr int kLine = 32, kName = 110, kBar = 240;
    const auto count = static_cast<int>(std::min(motors_.size(), frame.tau_a.size()));
    const mjrRect board = {20, 20, kName + kBar + 130, kLine * (count + 1) + 20};
    mjr_rectangle(board, 1.0F, 1.0F, 1.0F, 0.8F);
    std::vector<std::tuple<std::string, int, int>> words = {
        {"force of each motor", board.left + 15, board.bottom + kLine * count + 20}};
    for (int i = 0; i < count; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const double force = std::abs(frame.tau_a[k]), part = std::min(1.0, force / most);
      const int left = board.left + kName, y = board.bottom + 10 + kLine * (count - 1 - i);
      mjr_rectangle({left, y + 4, kBar, kLine - 12}, 0.86F, 0.86F, 0.86F, 1.0F);
      mjr_rectangle({left, y + 4, std::max(1, static_cast<int>(kBar * part)), kLine - 12}, kRed[0],
                    kRed[1], kRed[2], 1.0F);
      char text[40];
      std::snprintf(text, sizeof text, "%.1f %s", force, motors_[k][1].c_str());
      words.emplace_back(motors_[k][0], board.left + 15, y + 4);
      words.emplace_back(text, left + kBar + 15, y + 4);
    }
    const mjrRect legend = {20, kHeight - 125, 640, 105};
    mjr_rectangle(legend, 1.0F, 1.0F, 1.0F, 0.8F);
    words.emplace_back("skin: proxy, held back by what it touches", 35, kHeight - 53);
    words.emplace_back("blue: probe, the hand that wears the device", 35, kHeight - 83);
    words.emplace_back("red arrows: contact forces on the hand", 35, kHeight - 113);
    mjr_rectangle({0, 0, kWidth, kHeight}, 0.0F, 0.0F, 0.0F, 0.0F);  // places are relative to it
    for (const auto& [text, x, y] : words) {
      mjr_text(mjFONT_NORMAL, text.c_str(), &context_, static_cast<float>(x) / kWidth,
               static_cast<float>(y) / kHeight, 0.1F, 0.1F, 0.1F);
    }
  }

  OffScreen screen_{};
  mjModel* proxy_;
  std::unique_ptr<mjData, decltype(&mj_deleteData)> data_;
  std::unique_ptr<mjModel, decltype(&mj_deleteModel)> ghost_model_;
  std::unique_ptr<mjData, decltype(&mj_deleteData)> ghost_;
  std::optional<mujoco::Tool> tool_{};
  std::vector<std::array<std::string, 2>> motors_{};  ///< name and unit
  mjvScene scene_{};
  mjvOption look_{};
  mjvCamera camera_{};
  mjrContext context_{};
  std::vector<unsigned char> pixels_ = std::vector<unsigned char>(3 * kWidth * kHeight);
};

double felt(const FilmFrame& frame) {
  return std::accumulate(frame.tau_a.begin(), frame.tau_a.end(), 0.0,
                         [](double sum, double force) { return sum + std::abs(force); });
}

}  // namespace

std::vector<Touch> touches_of(const mjModel& model, const mjData& data, const mujoco::Tool& tool) {
  std::vector<Touch> found;
  for (int i = 0; i < data.ncon; ++i) {
    const mjContact& contact = data.contact[i];
    if (contact.efc_address < 0 || contact.geom1 < 0 || contact.geom2 < 0) continue;
    const bool first = tool.moves(model.geom_bodyid[contact.geom1]);
    if (!first && !tool.moves(model.geom_bodyid[contact.geom2])) continue;
    mjtNum force[6];
    mj_contactForce(&model, &data, i, force);
    if (!(force[0] > 0.0)) continue;
    Touch touch;
    mju_copy3(touch.position, contact.pos);
    mju_scl3(touch.force, contact.frame, first ? -force[0] : force[0]);
    found.push_back(touch);
  }
  return found;
}

void render(const FilmOptions& options, mjModel& model,
            const std::vector<mujoco::Binding>& bindings, const mujoco::ToolOptions& coupled,
            const client::DeviceInfo& device, const std::vector<FilmFrame>& frames) {
  double most = 1e-9;
  std::size_t best = 0;
  const auto worth = [&](std::size_t i) {
    return felt(frames[i]) * static_cast<double>(frames[i].touches.size());
  };
  for (std::size_t i = 0; i < frames.size(); ++i) {
    for (const double force : frames[i].tau_a) most = std::max(most, std::abs(force));
    if (worth(i) > worth(best)) best = i;
  }
  Stage stage(model, bindings, coupled, device);
  std::optional<Encoder> film;
  if (!options.film.empty()) {
    film.emplace(options.film, "-c:v libvpx-vp9 -b:v 0 -crf 36 -deadline realtime -cpu-used 6");
  }
  for (std::size_t i = 0; i < frames.size(); ++i) {
    stage.advance(frames[i]);
    const bool shown = i == best && !options.picture.empty();
    if (!shown && (!film || i % 2 != 0)) continue;
    const std::vector<unsigned char>& pixels = stage.draw(frames[i], most);
    if (film && i % 2 == 0) film->add(pixels);
    if (!shown) continue;
    Encoder picture(options.picture, "-frames:v 1");
    picture.add(pixels);
    picture.end();
  }
  if (film) film->end();
}

}  // namespace haptic::examples
