"""The ventilated brake on meshes that become finer, and with contacts of other stiffness."""
