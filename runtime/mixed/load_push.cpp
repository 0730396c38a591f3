#include "runtime/mixed/load_push.h"

namespace tremolo {

void LoadPush::set(GuestStep& body, const GuestLoad& load, double average) {
  shared = &own_;
  body_ = &body;
  load_ = &load;
  average_ = average;
}

void LoadPush::press(const ContactRenewal& renewal) {
  (void)renewal;
  for (const PointPush& push : load_->pushes) body_->add_force(push.point, average_ * push.force);
}

void LoadPush::settle(ContactAccount& first_account, ContactAccount& second_account,
                      double& first_start, double& second_start) const {
  (void)second_account;
  (void)first_start;
  (void)second_start;
  for (const PointPush& push : load_->pushes) {
    const SiteMotion motion = body_->motion(push.point);
    first_account.load_work += average_ * push.force.dot(motion.end - motion.start);
  }
}

}  // namespace tremolo
