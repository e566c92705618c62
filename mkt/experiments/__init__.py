"""What is asked of trackers: many runs, their statistics, claims, the leaderboard."""
