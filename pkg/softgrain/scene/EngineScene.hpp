// YADE keeps engines when their scene goes (O.reset), and they may be used again in another one.
#pragma once

#include "Yade.hpp"

namespace yade {

/// The scene that an engine runs in.
class EngineScene {
public:
	/// Whether it has run, and in another scene than the present one.
	bool isGone() const { return hasRun_ && scene_.lock() != Omega::instance().getScene(); }
	/// It runs in the present one.
	void enter()
	{
		scene_ = Omega::instance().getScene();
		hasRun_ = true;
	}

private:
	boost::weak_ptr<Scene> scene_;
	bool hasRun_ = false;
};

} // namespace yade
