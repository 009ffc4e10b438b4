"""What people look at: pictures, films, reports, figures, the live page."""
