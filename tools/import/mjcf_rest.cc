#include "tools/import/mjcf_rest.h"

#include <mujoco/mjxmacro.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string_view>

namespace unlatch::tools {
namespace {

// Fields that mjcf.cc reads, or for which it has remarks of its own.
constexpr std::string_view kRead[] = {
    "timestep",     "gravity",     "disableflags", "body_parentid", "body_jntnum",  "body_jntadr",   "body_pos",
    "body_quat",    "body_ipos",   "body_iquat",   "body_mass",     "body_inertia", "jnt_type",      "jnt_qposadr",
    "jnt_dofadr",   "jnt_limited", "jnt_range",    "jnt_pos",       "jnt_axis",     "jnt_stiffness", "dof_frictionloss",
    "dof_armature", "dof_damping", "geom_type",    "geom_bodyid",   "geom_dataid",  "geom_size",     "geom_pos",
    "geom_quat",    "eq_type",     "eq_obj1id",    "eq_obj2id",     "eq_active",    "eq_data"};
// Fields that MuJoCo computes from others, addresses, and what only pictures need.
constexpr std::string_view kDerived[] = {
    "apirate",        "body_rootid",   "body_weldid",    "body_dofnum",      "body_dofadr",     "body_geomnum",
    "body_geomadr",   "body_simple",   "body_sameframe", "body_subtreemass", "body_invweight0", "body_user",
    "jnt_bodyid",     "jnt_group",     "jnt_user",       "dof_bodyid",       "dof_jntid",       "dof_parentid",
    "dof_Madr",       "dof_simplenum", "dof_invweight0", "dof_M0",           "geom_matid",      "geom_group",
    "geom_sameframe", "geom_rbound",   "geom_user",      "geom_rgba",        "name_bodyadr",    "name_jntadr",
    "name_geomadr",   "name_eqadr"};
// Properties of contacts: one remark is for all of them.
constexpr std::string_view kContact[] = {"geom_contype", "geom_conaffinity", "geom_condim", "geom_priority",
                                         "geom_solmix",  "geom_solref",      "geom_solimp", "geom_friction",
                                         "geom_margin",  "geom_gap"};
// Elements of which all is left out; the remark's words.
struct Whole {
  int mjModel::*count;
  const char* words;
};
constexpr Whole kWhole[] = {{&mjModel::nmocap, "mocap bodies: they do not move"},
                            {&mjModel::nhfield, "height fields"},
                            {&mjModel::npair, "pairs of contacts"},
                            {&mjModel::nexclude, "exclusions of contacts"},
                            {&mjModel::nkey, "keyframes: the run starts at the reference"}};

// One element of each kind whose fields are compared.
constexpr char kEmpty[] =
    "<mujoco><worldbody><body name='b'><joint/><geom size='1'/></body></worldbody>"
    "<equality><connect body1='b' anchor='0 0 0'/></equality></mujoco>";

struct Delete {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
};
using Model = std::unique_ptr<mjModel, Delete>;

Model build_empty() {
  const auto files = std::make_unique<mjVFS>();  // large
  mj_defaultVFS(files.get());
  constexpr int kSize = sizeof kEmpty - 1;
  if (mj_makeEmptyFileVFS(files.get(), "empty.xml", kSize) != 0)
    throw std::runtime_error("MuJoCo has no room for a file");
  std::memcpy(files->filedata[0], kEmpty, kSize);
  char error[500] = "";
  Model model(mj_loadXML("empty.xml", files.get(), error, sizeof error));
  mj_deleteVFS(files.get());
  if (!model) throw std::runtime_error(std::string("MuJoCo cannot read an empty model: ") + error);
  return model;
}

template <std::size_t kSize>
bool is_in(const std::string_view (&list)[kSize], std::string_view name) {
  return std::find(std::begin(list), std::end(list), name) != std::end(list);
}

bool is_known(std::string_view name) { return is_in(kRead, name) || is_in(kDerived, name) || is_in(kContact, name); }

// Elements whose fields are compared, and the first of them in the empty model: body 0 is the world.
struct Element {
  std::string_view size;
  const char* words;
  int first;
};
constexpr Element kElements[] = {{"nbody", "bodies", 1},
                                 {"njnt", "joints", 0},
                                 {"nv", "degrees of freedom", 0},
                                 {"ngeom", "geoms", 0},
                                 {"neq", "equalities", 0}};

class Comparison {
 public:
  Comparison(const mjModel& model, const mjModel& empty) : m_(model), e_(empty) {}

  std::vector<std::string> list() {
#define X(type, name) compare_option(#name, &m_.opt.name, &e_.opt.name, 1);
    MJOPTION_SCALARS
#undef X
#define X(name, size) compare_option(#name, m_.opt.name, e_.opt.name, size);
    MJOPTION_VECTORS
#undef X
    MJMODEL_POINTERS_PREAMBLE((&m_))
    (void)nuser_body, (void)nuser_jnt, (void)nuser_geom, (void)nuser_site, (void)nuser_cam, (void)nuser_tendon;
    (void)nuser_actuator, (void)nuser_sensor, (void)nq, (void)nv, (void)na, (void)nu, (void)nmocap;
#define X(type, name, rows, columns) compare_rows(#name, #rows, m_.name, e_.name, m_.rows, columns);
    MJMODEL_POINTERS
#undef X
    for (const Whole& whole : kWhole)
      if (m_.*whole.count > 0) remarks_.push_back("left out: " + std::to_string(m_.*whole.count) + " " + whole.words);
    return std::move(remarks_);
  }

 private:
  template <class Number>
  void compare_option(const char* name, const Number* value, const Number* usual, int count) {
    if (!is_known(name) && !std::equal(value, value + count, usual))
      remarks_.push_back(std::string("left out: the option '") + name + "', which is not MuJoCo's default");
  }

  template <class Number>
  void compare_rows(const char* name, std::string_view size, const Number* values, const Number* usual, int rows,
                    int columns) {
    const auto* const element = std::find_if(std::begin(kElements), std::end(kElements),
                                             [&](const Element& known) { return known.size == size; });
    if (element == std::end(kElements) || is_known(name)) return;
    int different = 0;
    for (int i = element->first; i < rows; ++i)
      different +=
          std::equal(values + i * columns, values + (i + 1) * columns, usual + element->first * columns) ? 0 : 1;
    if (different > 0)
      remarks_.push_back(std::string("left out: ") + name + " of " + std::to_string(different) + " " + element->words +
                         ", which is not MuJoCo's default");
  }

  const mjModel &m_, &e_;
  std::vector<std::string> remarks_;
};

}  // namespace

std::vector<std::string> list_unread(const mjModel& model) {
  const Model empty = build_empty();
  return Comparison(model, *empty).list();
}

}  // namespace unlatch::tools
