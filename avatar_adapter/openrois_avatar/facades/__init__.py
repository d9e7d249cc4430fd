"""Facades: game engines that do WebRTC themselves, behind RoIS. Their media never passes through the adapter."""
